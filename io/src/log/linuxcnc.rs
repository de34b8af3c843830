//! `LinuxCNC` probe logs, as `(PROBEOPEN file)` writes them.

use crate::{InputError, source::Source};

use super::{
    Importer, LoggedPoint, Reader,
    scan::{self, Scanner, lines},
};

pub(super) const IMPORTER: Importer = Importer {
    name: "linuxcnc-probe",
    summary: "LinuxCNC probe logs (PROBEOPEN): nine numbers a line",
    about: "A point is a line of nine numbers, X Y Z A B C U V W; points have rows, no names. They are in the program's \
            unit (G20 or G21: state `units`), in the active coordinate system (state `base`, as G54). LinuxCNC does not \
            write a probe that ends where the one before ended: there can be fewer lines than probes.",
    extensions: &[],
    units: None,
    frame: None,
    reference: "LinuxCNC, G-codes: G38.n straight probe, (PROBEOPEN filename); its source, src/emc/task/emccanon.cc.",
    tip_centres: true,
    reader: Reader::Record(read),
};

/// X Y Z A B C U V W.
const NUMBERS: usize = 9;

fn read(source: &Source) -> Result<Vec<LoggedPoint>, InputError> {
    let text = source.text();
    let mut points = Vec::new();
    for line in lines(text) {
        let mut scanner = Scanner::new(text, line.clone());
        let mut tokens = Vec::new();
        while scanner.peek().is_some() {
            let token = scanner.token();
            if token.is_empty() {
                scanner.step();
            }
            tokens.push(token);
        }
        let [x, y, z, ..] = tokens.as_slice() else {
            if tokens.is_empty() {
                continue;
            }
            return Err(wrong(source, line, tokens.len()));
        };
        if tokens.len() != NUMBERS {
            return Err(wrong(source, line, tokens.len()));
        }
        let position = scan::point(text, [x.clone(), y.clone(), z.clone()]);
        points.push(LoggedPoint::new(None, line, position));
    }
    Ok(points)
}

fn wrong(source: &Source, line: std::ops::Range<usize>, found: usize) -> InputError {
    let message = format!("this line has {found} fields; expected {NUMBERS} numbers, X Y Z A B C U V W");
    InputError::new("invalid-input", message).at(source.place(line))
}
