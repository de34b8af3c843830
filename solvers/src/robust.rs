//! `robust`: names the bad touch, or says which touches cannot be told apart.
//!
//! All touches are solved for as `least-squares` does. When they are consistent nothing is accused, so sound
//! measurements are accused no oftener than once in a thousand, the level at which that solver calls them inconsistent.
//!
//! When they are not, every hypothesis "just these touches are bad" is tried: one touch, then two. The others must be
//! sound, so a search for all their frames tells whether any fits:
//!
//! | least squared misfit of the others | the hypothesis |
//! |---|---|
//! | below its 1e-3 level | explains the contradiction |
//! | above its 1e-6 level, and no frame was missed | is excluded; of true ones, one in a million |
//! | between, or not to be tested | may be |
//!
//! A set of touches is named only when it explains and every other set of its size is excluded; and left out only when
//! the frame of the others is [accepted](crate#when-a-frame-is-accepted). Otherwise the refusal lists what may be. With
//! few touches that is most of them, by nature: a bad touch of seven is noticed, but never told which; three touches on
//! a plane are one number to a cylinder, so none of them is told from the others (W. Baarda, A testing procedure for use in
//! geodetic networks, 1968). Subsets are enumerated, not sampled: the answer is exact, and the same every time.
//!
//! What is named is the smallest set that explains. More bad touches than redundancy can tell may look like fewer: two on
//! nine may look like another one.
//!
//! A wrong label looks like a bad touch, too. Each touch is tried on each other surface, and the labels of two surfaces
//! exchanged; what fits then is told, never applied: a label is the user's to correct.

use touchref_core::{
    ParameterError, ParameterKind, ParameterSpec, Parameters, Problem, Residual, Solution, SolveError,
    Solver, SolverPlugin, Touch, Warning,
};

use crate::{
    acceptance::{Judgement, Margin, Verdict},
    least_squares::Answer,
    model::{Model, uncertain, with_unknowns},
    words::{either, listed, short, touches_in_words},
};

/// Most hypotheses that are tried: some seconds of work.
const MOST: usize = 5000;

/// How many touches may be bad at once.
const BAD: ParameterSpec = ParameterSpec {
    name: "bad",
    kind: ParameterKind::Choice(&["1", "2", "3"]),
    default: Some("2"),
    meaning: "how many touches may be bad at once; more are looked for only where fewer do not explain",
};

/// The plugin.
pub static PLUGIN: SolverPlugin = SolverPlugin {
    name: "robust",
    summary: "least-squares that names a bad touch and leaves it out, or says which touches may be bad",
    origin: module_path!(),
    parameters: &[BAD, Margin::SPEC],
    about: "Solves as `least-squares` does; where the touches contradict the fixture, tries every hypothesis that one \
            touch is bad, then two. The only set of touches without which a frame fits is named and left out, with a \
            warning; where several may be it, the refusal lists them. Says, too, which labels would make the touches \
            fit, and finds those of touches whose surface is not known. Wants a sigma. Nine touches (5 + 4, 3 + 3 + 3) \
            are the fewest that can tell any one bad touch.",
    reference: "Baarda, A testing procedure for use in geodetic networks (1968); acceptance: see docs of \
                touchref-solvers",
    build,
};
touchref_core::register_solver!(PLUGIN);

fn build(parameters: &Parameters) -> Result<Box<dyn Solver>, ParameterError> {
    let parameters = parameters.checked(PLUGIN.parameters)?;
    let bad = parameters.word(BAD.name).parse().unwrap_or(Robust::default().bad);
    Ok(Box::new(Robust { bad, margin: Margin::of(&parameters) }))
}

/// Least squares that names a bad touch and leaves it out, or says which touches may be bad.
#[derive(Debug, Clone, Copy)]
pub struct Robust {
    /// How many touches may be bad at once.
    pub bad: usize,
    /// How far beyond the stated noise other frames are looked for.
    pub margin: Margin,
}

impl Default for Robust {
    fn default() -> Self {
        Self { bad: 2, margin: Margin::default() }
    }
}

impl Solver for Robust {
    fn name(&self) -> &'static str {
        PLUGIN.name
    }

    fn solve(&self, problem: &Problem<'_>) -> Result<Solution, SolveError> {
        if problem.expected_near().is_none() {
            problem.require_enough()?;
        }
        require_sigma(problem)?;
        match self.locate(problem, problem) {
            Err(contradiction) if is_contradiction(&contradiction) => {
                let labels = labels_that_fit(problem)?;
                Inquiry { solver: self, problem, contradiction, labels }.settle()
            }
            outcome => outcome,
        }
    }
}

/// Whether a touch is bad is a question to the noise.
pub(crate) fn require_sigma(problem: &Problem<'_>) -> Result<(), SolveError> {
    if problem.reference_sigma().is_some() {
        return Ok(());
    }
    Err(SolveError::Unsupported {
        solver: PLUGIN.name,
        reason: "no sigma is stated, and without one no touch is bad; state that of the probe, or of every touch; \
                 `least-squares` solves without"
            .to_owned(),
    })
}

/// Whether a refusal says that no frame fits the touches; approach directions alone do not.
fn is_contradiction(refusal: &SolveError) -> bool {
    match refusal {
        SolveError::Inconsistent(refusal) => {
            refusal.trust.sigma.is_some_and(|sigma| refusal.trust.from_sigma > sigma)
        }
        SolveError::InvalidTouches { .. } => true,
        _ => false,
    }
}

impl Robust {
    /// The frame of some touches, and the residuals of all.
    fn locate(&self, all: &Problem<'_>, some: &Problem<'_>) -> Result<Solution, SolveError> {
        let extras = uncertain(some);
        with_unknowns!(extras.len(), P => {
            let model = Model::<P>::new(some, &extras);
            let judgement = Judgement::of(&model, self.margin)?;
            let answer = Answer { solver: PLUGIN.name, problem: some, model, judgement };
            let (mut solution, at) = answer.settle()?;
            let model = Model::<P>::new(all, &extras);
            let residuals = (0..all.touches().len()).map(|index| model.residual(&at, index));
            solution.residuals = residuals
                .map(|(length, normalized)| Residual { length, normalized: Some(normalized) })
                .collect();
            Ok(solution)
        })
    }
}

/// Touches that contradict the fixture, and what could be wrong with them.
struct Inquiry<'a, 'p> {
    solver: &'a Robust,
    problem: &'a Problem<'p>,
    /// What `least-squares` says of all touches.
    contradiction: SolveError,
    /// Labels with which all touches fit.
    labels: Vec<Labels>,
}

/// A set of touches that may be bad.
struct Suspects {
    touches: Vec<usize>,
    verdict: Verdict,
}

impl Inquiry<'_, '_> {
    fn settle(self) -> Result<Solution, SolveError> {
        let total = self.problem.touches().len();
        let mut cleared = 0;
        // Without a degree of freedom left, any touches fit.
        for count in (1..=self.solver.bad).take_while(|count| total > 6 + count) {
            let sets = subsets(total, count);
            if sets.clone().nth(MOST).is_some() {
                return Err(self.beyond_budget(count));
            }
            let mut open = Vec::new();
            for touches in sets {
                let verdict = self.without(&touches, |rest| Ok(Verdict::of(rest)))?;
                if verdict != Verdict::Excluded {
                    open.push(Suspects { touches, verdict });
                }
            }
            match open.as_slice() {
                [] => cleared = count,
                [one] if one.verdict == Verdict::Fits && self.labels_concern_only(&one.touches) => {
                    return self.leave_out(&one.touches);
                }
                _ => return Err(self.undecided(&open)),
            }
        }
        Err(self.unexplained(cleared))
    }

    /// What is made of the measurement without some of its touches.
    fn without<T>(
        &self,
        left_out: &[usize],
        make: impl FnOnce(&Problem<'_>) -> Result<T, SolveError>,
    ) -> Result<T, SolveError> {
        let numbers: Vec<usize> =
            (0..self.problem.touches().len()).filter(|index| !left_out.contains(index)).collect();
        let touches: Vec<Touch> = numbers.iter().map(|index| self.problem.touches()[*index]).collect();
        make(&part(self.problem, &touches, &numbers)?)
    }

    fn labels_concern_only(&self, touches: &[usize]) -> bool {
        self.labels.iter().all(|labels| matches!(labels, Labels::Of { touch, .. } if touches.contains(touch)))
    }

    /// The frame without the touches that are bad.
    fn leave_out(&self, bad: &[usize]) -> Result<Solution, SolveError> {
        let named = touches_in_words(self.problem, bad);
        let mut solution = self
            .without(bad, |rest| self.solver.locate(self.problem, rest))
            .map_err(|refusal| without_bad(refusal, &named, bad))?;
        let fit = solution.chi_square.map_or(String::new(), |chi_square| {
            format!("chi-square {} with {} degrees of freedom", short(chi_square), solution.degrees_of_freedom)
        });
        let others = if bad.len() == 1 { "one touch" } else { "set of as few" };
        for &index in bad {
            let Residual { length, normalized } = solution.residuals[index];
            let label = self.labels.iter().map(|labels| format!("; {}", labels.in_words(self.problem)));
            solution.warnings.push(Warning {
                code: "touch-excluded",
                message: format!(
                    "{} is left out as bad: it lies {} off its surface, {} standard deviations; without {} the touches \
                     fit ({fit}), without any other {others} they do not{}",
                    touches_in_words(self.problem, &[index]),
                    short(length),
                    short(normalized.unwrap_or(f64::NAN)),
                    if bad.len() == 1 { "it" } else { &named },
                    label.collect::<String>(),
                ),
            });
        }
        solution.excluded = bad.to_vec();
        Ok(solution)
    }

    /// Several sets of touches may be bad, or one that is not sure to be.
    fn undecided(self, open: &[Suspects]) -> SolveError {
        let mut touches: Vec<usize> = open.iter().flat_map(|set| set.touches.iter().copied()).collect();
        touches.sort_unstable();
        touches.dedup();
        let one_each = open.iter().all(|set| set.touches.len() == 1);
        let may_be = if one_each {
            format!("one touch is bad, and it may be {}", either(&self.numbers(&touches)))
        } else {
            let sets: Vec<String> = open.iter().map(|set| listed(&self.numbers(&set.touches))).collect();
            let count = open[0].touches.len();
            format!("no {} explain it, {count} bad ones do: touches {}", fewer(count), either(&sets))
        };
        let untested = open.iter().filter(|set| set.verdict == Verdict::Untested).count();
        let why = match (open, untested) {
            ([one], _) if one.verdict == Verdict::Fits => {
                ", unless labels are wrong".to_owned()
            }
            ([_], 0) => ", but hardly: the others do not fit well without it".to_owned(),
            (_, 0) => ": without each of these the others fit or nearly so".to_owned(),
            _ => {
                let those = open.iter().filter(|set| set.verdict == Verdict::Untested);
                let mut those: Vec<usize> = those.flat_map(|set| set.touches.iter().copied()).collect();
                those.sort_unstable();
                those.dedup();
                format!(
                    "; without {} there are too few left on a surface to tell",
                    either(&self.numbers(&those))
                )
            }
        };
        let help = self.one_more_on(&touches);
        self.refuse(&format!("{may_be}{why}"), &help, touches)
    }

    /// No set of touches explains, of those that could be tried: up to so many at once.
    fn unexplained(self, cleared: usize) -> SolveError {
        let total = self.problem.touches().len();
        let all: Vec<usize> = (0..total).collect();
        if cleared > 0 {
            let words = format!(
                "no {} alone explain{} it",
                if cleared == 1 { "bad touch".to_owned() } else { format!("{cleared} bad touches") },
                if cleared == 1 { "s" } else { "" }
            );
            let more = if total > 7 + cleared && cleared == self.solver.bad {
                "raise `bad` where more touches may be bad at once".to_owned()
            } else {
                self.one_more_on(&all)
            };
            return self.refuse(&words, &more, Vec::new());
        }
        let words = format!(
            "with {total} touches a bad one is noticed, but never told which: without any one of them the others fit \
             whatever they are"
        );
        let help = self.one_more_on(&all);
        self.refuse(&words, &help, all)
    }

    fn beyond_budget(self, count: usize) -> SolveError {
        let total = self.problem.touches().len();
        let words = format!(
            "to tell which {count} of {total} touches are bad takes more than {MOST} searches, and fewer bad ones do not \
             explain it"
        );
        self.refuse(&words, "measure anew, or solve with part of the touches", Vec::new())
    }

    /// Which touches would tell more.
    fn one_more_on(&self, touches: &[usize]) -> String {
        let fixture = self.problem.fixture();
        let touched = |surface: &usize| touches.iter().any(|index| self.surface_of(*index) == *surface);
        let surfaces: Vec<String> = (0..fixture.surfaces().len())
            .filter(touched)
            .map(|surface| format!("`{}`", fixture.surfaces()[surface].name))
            .collect();
        let each = if surfaces.len() == 1 { "" } else { "each of " };
        format!("one more touch on {each}{} would tell more", listed(&surfaces))
    }

    fn surface_of(&self, index: usize) -> usize {
        self.problem.touches()[index].surface
    }

    fn numbers(&self, touches: &[usize]) -> Vec<String> {
        touches.iter().map(|index| self.problem.number(*index).to_string()).collect()
    }

    /// The contradiction, with what was found out.
    fn refuse(self, words: &str, help: &str, touches: Vec<usize>) -> SolveError {
        let labels = self.labels.iter().map(|labels| format!("{}; ", labels.in_words(self.problem)));
        let advice = format!("{}{help}", labels.collect::<String>());
        match self.contradiction {
            SolveError::Inconsistent(mut refusal) => {
                refusal.message = format!("{}; {words}", refusal.message);
                refusal.help = format!("{advice}; else {}", refusal.help);
                refusal.touches = touches;
                SolveError::Inconsistent(refusal)
            }
            SolveError::InvalidTouches { problem, help, touches: concerned } => SolveError::InvalidTouches {
                problem: format!("{problem}; {words}"),
                help: format!("{advice}; else {help}"),
                touches: if concerned.is_empty() { touches } else { concerned },
            },
            other => other,
        }
    }
}

/// A refusal of the touches that are left.
fn without_bad(refusal: SolveError, named: &str, bad: &[usize]) -> SolveError {
    let told = |mut refusal: Box<touchref_core::Refusal>| {
        refusal.message = format!("{named} is bad, but without it the frame does not stand: {}", refusal.message);
        refusal.touches = bad.to_vec();
        refusal
    };
    match refusal {
        SolveError::Ambiguous(refusal) => SolveError::Ambiguous(told(refusal)),
        SolveError::Inconsistent(refusal) => SolveError::Inconsistent(told(refusal)),
        SolveError::NotValidated(refusal) => SolveError::NotValidated(told(refusal)),
        SolveError::Degenerate(mut details) => {
            details.help = format!("{named} is bad and was left out: touch there again; {}", details.help);
            SolveError::Degenerate(details)
        }
        other => other,
    }
}

fn fewer(count: usize) -> String {
    if count == 2 { "single touch".to_owned() } else { format!("{} touches", count - 1) }
}

/// Other labels than the touches have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Labels {
    /// One touch is on another surface.
    Of { touch: usize, surface: usize },
    /// The touches of two surfaces are on each other's.
    Exchanged([usize; 2]),
}

impl Labels {
    /// The surface of a touch that is labelled `surface`.
    fn of(self, touch: usize, surface: usize) -> usize {
        match self {
            Self::Of { touch: own, surface: other } if own == touch => other,
            Self::Exchanged([one, other]) if surface == one => other,
            Self::Exchanged([other, one]) if surface == one => other,
            _ => surface,
        }
    }

    fn in_words(self, problem: &Problem<'_>) -> String {
        let name = |surface: usize| &problem.fixture().surfaces()[surface].name;
        match self {
            Self::Of { touch, surface } => format!(
                "touch {} fits as `{}`, not `{}`: correct its label if it was there",
                problem.number(touch),
                name(surface),
                name(problem.touches()[touch].surface)
            ),
            Self::Exchanged([one, other]) => {
                format!("all touches fit when the labels `{}` and `{}` are exchanged", name(one), name(other))
            }
        }
    }
}

/// The labels, one step from those that the touches have, with which all of them fit.
fn labels_that_fit(problem: &Problem<'_>) -> Result<Vec<Labels>, SolveError> {
    let surfaces = problem.fixture().surfaces().len();
    let counts = problem.counts();
    let exchanges = subsets(surfaces, 2)
        .map(|pair| Labels::Exchanged([pair[0], pair[1]]))
        .filter(|labels| matches!(labels, Labels::Exchanged(pair) if pair.iter().any(|s| counts[*s] > 0)));
    let single = problem.touches().iter().enumerate().flat_map(|(touch, own)| {
        let others = (0..surfaces).filter(move |surface| *surface != own.surface);
        others.map(move |surface| Labels::Of { touch, surface })
    });
    let numbers: Vec<usize> = (0..problem.touches().len()).map(|index| problem.number(index)).collect();
    let mut fitting = Vec::new();
    for labels in exchanges.chain(single).take(MOST) {
        let relabelled = problem.touches().iter().enumerate();
        let relabelled: Vec<Touch> = relabelled
            .map(|(index, touch)| Touch { surface: labels.of(index, touch.surface), ..*touch })
            .collect();
        if Verdict::of(&part(problem, &relabelled, &numbers)?) == Verdict::Fits {
            fitting.push(labels);
        }
    }
    Ok(fitting)
}

/// Touches of a measurement, in a problem of their own.
fn part<'b>(
    problem: &Problem<'b>,
    touches: &'b [Touch],
    numbers: &'b [usize],
) -> Result<Problem<'b>, SolveError> {
    // Those of a sound measurement are sound.
    problem.with_touches(touches, numbers).map_err(|error| SolveError::InvalidTouches {
        problem: error.to_string(),
        help: String::new(),
        touches: Vec::new(),
    })
}

/// Every subset of so many of the first numbers, in order.
fn subsets(total: usize, count: usize) -> impl Iterator<Item = Vec<usize>> + Clone {
    let first = (count <= total).then(|| (0..count).collect::<Vec<usize>>());
    std::iter::successors(first, move |last| {
        let moves = (0..count).rev().find(|k| last[*k] < total - count + k)?;
        let mut next = last.clone();
        next[moves] += 1;
        for k in moves + 1..count {
            next[k] = next[k - 1] + 1;
        }
        Some(next)
    })
}

#[cfg(test)]
mod tests {
    use super::subsets;

    #[test]
    fn every_subset_comes_once_and_in_order() {
        let all: Vec<Vec<usize>> = subsets(6, 3).collect();
        assert_eq!(all.len(), 20);
        assert!(all.windows(2).all(|pair| pair[0] < pair[1]), "{all:?}");
        assert!(all.iter().all(|set| set.windows(2).all(|pair| pair[0] < pair[1]) && set[2] < 6));
        assert_eq!(subsets(2, 3).count(), 0);
        assert_eq!(subsets(3, 3).collect::<Vec<_>>(), [[0, 1, 2]]);
    }
}
