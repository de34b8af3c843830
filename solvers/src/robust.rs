//! `robust`: names the bad touch, or says which touches cannot be told apart.
//!
//! All touches are solved for as `least-squares` does. When they are consistent nothing is accused, so sound
//! measurements are accused no oftener than once in a thousand, the level at which that solver calls them inconsistent.
//!
//! When they are not, every hypothesis "just these touches are bad" is tried: of one touch, and of as many as the
//! parameter `bad` allows. The others must be sound, so a search for all their frames tells whether any fits:
//!
//! | least squared misfit of the others | the hypothesis |
//! |---|---|
//! | below its 1e-3 level | explains the contradiction |
//! | above its 1e-6 level, and no frame was missed | is excluded; of true ones, one in a million |
//! | between, or not to be tested | may be |
//!
//! A set of touches is named only when it explains and every other set is excluded, but for those that it is part of; and
//! left out only when the frame of the others is [accepted](crate#when-a-frame-is-accepted). Otherwise the refusal lists
//! what may be. With few touches that is most of them, by nature: a bad touch of seven is noticed, but never told which;
//! three touches on a plane are one number to a cylinder, so none of them is told from the others (W. Baarda, A testing
//! procedure for use in geodetic networks, 1968). Subsets are enumerated, not sampled: the answer is exact, and the same
//! every time.
//!
//! A size that is wrong looks like a bad touch, too: nothing is named when all touches fit, or nearly so, once a dimension of
//! the fixture or the tip radius is free.
//!
//! All this is true if no more than `bad` touches are. Two bad ones of nine may look like a third one; with `bad` = 2
//! nothing is named then, nor is a single one, as two others might look like it. Fourteen touches tell two.
//!
//! A wrong label looks like a bad touch, too. Each touch is tried on each other surface, and the labels of two surfaces
//! exchanged; what fits then is told, never applied: a label is the user's to correct.

use touchref_core::{
    Frame, ParameterError, ParameterKind, ParameterSpec, Parameters, Problem, Residual, Solution, SolveError,
    Solver, SolverPlugin, Stated, Touch, Unknown, Warning,
};

use crate::{
    acceptance::{AMBIGUOUS, Judgement, Margin, Search, Verdict, degrees_of_freedom},
    least_squares::Answer,
    levenberg_marquardt::descend,
    model::{Extra, Model, Unknowns, uncertain, with_unknowns},
    words::{either, joined, listed, short, touches_in_words},
};

/// Most hypotheses that are tried: some seconds of work.
const MOST: usize = 5000;

/// How many touches may be bad at once.
const BAD: ParameterSpec = ParameterSpec {
    name: "bad",
    kind: ParameterKind::Choice(&["1", "2", "3"]),
    default: Some("1"),
    meaning: "how many touches may be bad at once: a touch is left out only when nothing else explains the \
              contradiction, be it so many bad ones",
};

/// The plugin.
pub static PLUGIN: SolverPlugin = SolverPlugin {
    name: "robust",
    summary: "least-squares that names a bad touch and leaves it out, or says which touches may be bad",
    origin: module_path!(),
    parameters: &[BAD, Margin::SPEC],
    about: "Solves as `least-squares` does; where the touches contradict the fixture, tries every hypothesis that one \
            touch is bad (or two, with `bad=2`). The only set of touches without which a frame fits is named and left \
            out, with a warning; where several may be it, the refusal lists them. Says, too, which labels would make \
            the touches fit, and finds the surface of a touch whose file leaves it open (`?`). Wants a sigma. Nine \
            touches (5 + 4, 3 + 3 + 3) are the fewest that can tell any one bad touch.",
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
        Self { bad: 1, margin: Margin::default() }
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
            Err(SolveError::Degenerate(mut details)) => {
                // Touches of one surface, taken for another's, may leave a motion free.
                for labels in labels_that_fit(problem)? {
                    details.help = format!("{}; {}", labels.in_words(problem), details.help);
                }
                Err(SolveError::Degenerate(details))
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
            let judgement = Judgement::of(&model, Search::Fixture, self.margin)?;
            let answer =
                Answer { solver: PLUGIN.name, problem: some, search: Search::Fixture, model, judgement };
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
        // Only the smallest: what more touches are left out of fits no worse.
        let mut open: Vec<Suspects> = Vec::new();
        for count in 1..=self.solver.bad {
            // Without a degree of freedom left, any touches fit.
            if total <= self.problem.unknowns() + count {
                return Err(self.undecided(&open));
            }
            if subsets(total, count).nth(MOST).is_some() {
                return Err(self.beyond_budget(&open, count));
            }
            for touches in subsets(total, count) {
                if open.iter().any(|set| set.touches.iter().all(|touch| touches.contains(touch))) {
                    continue;
                }
                let verdict = self.without(&touches, |rest| Ok(Verdict::of(rest)))?;
                if verdict != Verdict::Excluded {
                    open.push(Suspects { touches, verdict });
                }
            }
        }
        match open.as_slice() {
            [] => Err(self.unexplained()),
            [one]
                if one.verdict == Verdict::Fits
                    && self.labels.iter().all(|labels| labels.concern_only(&one.touches)) =>
            {
                let sizes = self.sizes_that_fit(&one.touches)?;
                if sizes.is_empty() { self.leave_out(&one.touches) } else { Err(self.or_sizes(one, &sizes)) }
            }
            _ => Err(self.undecided(&open)),
        }
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
        make(&self.problem.with_touches(&touches, &numbers)?)
    }

    /// Sizes of fixture and tip, each free by itself, with which all touches fit or nearly so.
    fn sizes_that_fit(&self, bad: &[usize]) -> Result<Vec<String>, SolveError> {
        let problem = self.problem;
        let mut starts = starts(problem);
        starts.extend(self.without(bad, |rest| Ok(self::starts(rest)))?);
        let sizes =
            (0..problem.fixture().dimensions().len()).map(Unknown::Dimension).chain([Unknown::TipRadius]);
        let level = AMBIGUOUS.value(degrees_of_freedom(problem) - 1);
        let mut fitting = Vec::new();
        for what in sizes {
            let Stated { name, nominal, scale, .. } = what.stated(problem.fixture(), problem.probe());
            let mut extras = vec![Extra { what, prior: None }];
            extras.extend(uncertain(problem).into_iter().filter(|extra| extra.what != what));
            let best = with_unknowns!(extras.len(), P => {
                let model = Model::<P>::new(problem, &extras);
                let ends = starts.iter().map(|start| descend(&model, Unknowns::at(*start)));
                let ends = ends.map(|end| (end.chi_square(), end.at.extras[0]));
                Ok(ends.min_by(|a, b| a.0.total_cmp(&b.0)))
            })?;
            if let Some(end) = best.filter(|end| end.0 <= level) {
                let value = nominal + end.1;
                fitting.push(format!("`{name}` is {}, not {}", short(value * scale), short(nominal * scale)));
            }
        }
        Ok(fitting)
    }

    /// One set of touches explains, but so does a size that is wrong.
    fn or_sizes(&self, one: &Suspects, sizes: &[String]) -> SolveError {
        let named = touches_in_words(self.problem, &one.touches);
        let told = format!("either {named} is bad, or {}", either(sizes));
        let advice = format!("check these sizes; {}", self.one_more_on(&one.touches));
        self.refuse(&told, &advice, one.touches.clone())
    }

    /// The frame without the touches that are bad.
    fn leave_out(&self, bad: &[usize]) -> Result<Solution, SolveError> {
        let mut solution = self.without(bad, |rest| {
            let outcome = self.solver.locate(self.problem, rest);
            outcome.map_err(|refusal| without_bad(refusal, &touches_in_words(self.problem, bad), bad))
        })?;
        let most = self.solver.bad;
        let (others, are) = if most == 1 { ("any other one", "is") } else { ("any others", "are") };
        let chi_square = short(solution.chi_square.unwrap_or_default());
        let degrees = solution.degrees_of_freedom;
        for &index in bad {
            let Residual { length, normalized } = solution.residuals[index];
            let mut told = vec![format!(
                "{} is left out as bad: it lies {} off its surface, {} standard deviations; the touches that are left \
                 fit (chi-square {chi_square}, touches less unknowns {degrees}), without {others} they do not; this \
                 stands if no more than {most} of them {are} bad",
                touches_in_words(self.problem, &[index]),
                short(length),
                short(normalized.unwrap_or_default()),
            )];
            let of_it = self.labels.iter().filter(|labels| labels.concern_only(&[index]));
            told.extend(of_it.map(|labels| labels.in_words(self.problem)));
            let message = told.join("; ");
            solution.warnings.push(Warning { code: "touch-excluded", message });
        }
        solution.excluded = bad.to_vec();
        Ok(solution)
    }

    /// Several sets of touches may be bad; or one that is not sure to be.
    fn undecided(&self, open: &[Suspects]) -> SolveError {
        let (total, most) = (self.problem.touches().len(), self.solver.bad);
        if total <= self.problem.unknowns() + most {
            let bad = if most == 1 { "a bad one is" } else { "so many bad ones are" };
            let told =
                format!("of {total} touches {bad} noticed, but never told: the others fit whatever they are");
            let all: Vec<usize> = (0..total).collect();
            return self.refuse(&told, &self.one_more_on(&all), all);
        }
        let suspects = union(open.iter());
        let mut told = if most == 1 {
            format!("one touch is bad, and it may be {}", either(&self.numbers(&suspects)))
        } else {
            let sets: Vec<String> = open.iter().map(|set| listed(&self.numbers(&set.touches))).collect();
            format!("up to {most} touches are bad, and they may be {}", joined(&sets, ";", "or"))
        };
        let untested = union(open.iter().filter(|set| set.verdict == Verdict::Untested));
        if !untested.is_empty() {
            let those = either(&self.numbers(&untested));
            told = format!("{told} (without {those} the others are too few, or too weak, to tell)");
        } else if matches!(open, [one] if one.verdict == Verdict::Doubtful) {
            told.push_str(", but the others hardly fit without");
        }
        self.refuse(&told, &self.one_more_on(&suspects), suspects)
    }

    /// However many may be bad, the others do not fit.
    fn unexplained(&self) -> SolveError {
        let most = self.solver.bad;
        let told = match most {
            1 => "no one bad touch explains it".to_owned(),
            _ => format!("no {most} bad touches explain it"),
        };
        let advice = format!("where more than {most} may be bad, solve with a larger `{}`", BAD.name);
        self.refuse(&told, &advice, Vec::new())
    }

    fn beyond_budget(&self, open: &[Suspects], count: usize) -> SolveError {
        let total = self.problem.touches().len();
        let told =
            format!("which {count} of {total} touches are bad takes more than {MOST} searches to tell");
        let advice = format!("solve with part of the touches, or with a smaller `{}`", BAD.name);
        self.refuse(&told, &advice, union(open.iter()))
    }

    /// More touches where the suspects are.
    fn one_more_on(&self, suspects: &[usize]) -> String {
        let problem = self.problem;
        let surfaces = problem.fixture().surfaces().iter().enumerate();
        let suspected =
            |surface: usize| suspects.iter().any(|touch| problem.touches()[*touch].surface == surface);
        let names: Vec<String> = surfaces
            .filter(|(surface, _)| suspected(*surface))
            .map(|(_, surface)| format!("`{}`", surface.name))
            .collect();
        let each = if names.len() == 1 { "" } else { "each of " };
        format!("one more touch on {each}{}, away from the others, would tell more", listed(&names))
    }

    fn numbers(&self, touches: &[usize]) -> Vec<String> {
        touches.iter().map(|index| self.problem.number(*index).to_string()).collect()
    }

    /// The contradiction, with what was found out.
    fn refuse(&self, told: &str, advice: &str, suspects: Vec<usize>) -> SolveError {
        let mut advised: Vec<String> =
            self.labels.iter().map(|labels| labels.in_words(self.problem)).collect();
        advised.push(advice.to_owned());
        let helped = |help: &str| format!("{}; else {help}", advised.join("; "));
        match self.contradiction.clone() {
            SolveError::Inconsistent(mut refusal) => {
                refusal.message = format!("{}; {told}", refusal.message);
                refusal.help = helped(&refusal.help);
                refusal.touches = suspects;
                SolveError::Inconsistent(refusal)
            }
            SolveError::InvalidTouches { problem, help, touches } => SolveError::InvalidTouches {
                problem: format!("{problem}; {told}"),
                help: helped(&help),
                // To suspect all is to suspect none.
                touches: if (1..self.problem.touches().len()).contains(&suspects.len()) {
                    suspects
                } else {
                    touches
                },
            },
            other => other,
        }
    }
}

/// The touches of all these sets.
fn union<'a>(sets: impl Iterator<Item = &'a Suspects>) -> Vec<usize> {
    let mut touches: Vec<usize> = sets.flat_map(|set| set.touches.iter().copied()).collect();
    touches.sort_unstable();
    touches.dedup();
    touches
}

/// Frames near which touches may fit: roots, whose measured dimensions are free, and minima.
fn starts(problem: &Problem<'_>) -> Vec<Frame> {
    let mut frames = Vec::new();
    if let Some(closed_form) = problem.fixture().closed_form() {
        // Where it refuses, the minima are left.
        let _ = closed_form.roots(problem, &mut |root| frames.push(root.frame));
    }
    let extras = uncertain(problem);
    let judgement = with_unknowns!(extras.len(), P => {
        Judgement::of(&Model::<P>::new(problem, &extras), Search::Fixture, Margin::Near)
    });
    frames
        .extend(judgement.iter().flat_map(|judgement| &judgement.minima).map(|minimum| minimum.state.frame));
    frames
}

/// A refusal of the touches that are left.
fn without_bad(refusal: SolveError, named: &str, bad: &[usize]) -> SolveError {
    let told = |mut refusal: Box<touchref_core::Refusal>| {
        refusal.message =
            format!("{named} is bad, but without it the frame does not stand: {}", refusal.message);
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

    /// Whether they differ for one of these touches only.
    fn concern_only(self, touches: &[usize]) -> bool {
        matches!(self, Self::Of { touch, .. } if touches.contains(&touch))
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
        if Verdict::of(&problem.with_touches(&relabelled, &numbers)?) == Verdict::Fits {
            fitting.push(labels);
        }
    }
    Ok(fitting)
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
