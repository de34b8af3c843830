//! The frame in every dialect that is linked in.

use touchref_core::{DialectPlugin, Literal, ParameterKind, Registry};
use touchref_io::dialect;

use crate::subject::Subject;

/// The most wordings of a dialect that asks how it is to be worded.
const MOST_WORDINGS: usize = 64;

/// A dialect, in each wording.
pub(crate) struct Told {
    pub(crate) plugin: &'static DialectPlugin,
    /// How each is asked for, and the literal, or why there is none.
    pub(crate) wordings: Vec<(String, Result<Literal, String>)>,
}

/// The frame in every dialect, in the order of their names: plainly, in every wording where one must be chosen, and as the
/// result was asked for.
pub(crate) fn told(subject: &Subject<'_>, registry: &Registry) -> Vec<Told> {
    let touched = subject.touched();
    let literal = |name: &str| {
        let dialect = dialect::find(registry, name).map_err(|error| error.to_string())?;
        Literal::new(name, &*dialect, &subject.frame, subject.units, &touched)
            .map_err(|error| format!("{error}; {}", error.help()))
    };
    let dialects = registry.dialects().iter().copied().map(|plugin| {
        let mut names = plainly(plugin);
        let asked = subject.record.dialects.keys().filter(|name| name.split(':').next() == Some(plugin.name));
        names.extend(asked.filter(|name| *name != plugin.name).cloned());
        names.dedup();
        let wordings = names.into_iter().map(|name| (name.clone(), literal(&name))).collect();
        Told { plugin, wordings }
    });
    dialects.collect()
}

/// How a dialect is asked for without more words than it needs: once, or with every choice that it leaves.
fn plainly(plugin: &DialectPlugin) -> Vec<String> {
    let mut names = vec![plugin.name.to_owned()];
    for spec in plugin.parameters.iter().filter(|spec| spec.default.is_none()) {
        match spec.kind {
            ParameterKind::Choice(words) if names.len() * words.len() <= MOST_WORDINGS => {
                names = names
                    .iter()
                    .flat_map(|name| words.iter().map(move |word| format!("{name}:{word}")))
                    .collect();
            }
            // It says itself what is missing.
            _ => return vec![plugin.name.to_owned()],
        }
    }
    names
}
