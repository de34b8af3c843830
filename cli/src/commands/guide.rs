//! `guide`: touch by touch.

use std::io::{self, BufRead, Read as _};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use touchref::{
    Frame, Problem, Registry, Solution, SolveError, Touch,
    analysis::planning::{Next, Planner, free_motions, worst_case},
    fixture::touches_per_surface,
    io::{
        ErrorRecord, InputError, SolutionRecord, TouchRecord,
        refusal::ErrorDetails,
        schema,
        solution::{Context, WarningRecord},
        table::TableReader,
    },
};

use crate::{
    args::Format,
    commands::plan::{NextTouch, PointRecord, nominal_counts},
    failure::Failure,
    output::{Answers, Output},
    planning::{PlanningArgs, can_aim, coverage_factor, length},
    setup::{MeasurementArgs, NearArgs, Setup, SolverArgs},
    text::{self, Look},
};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.guide/1";

/// What messages call the input.
const INPUT: &str = "standard input";
/// The header of lines that come without one.
const HEADERS: [&str; 2] = ["surface,x,y,z", "surface,x,y,z,i,j,k"];
/// Takes the last touch back.
const UNDO: &str = "undo";

/// Guide the probe touch by touch: what is still free, how sure the frame is, where to touch next, when to stop
///
/// Reads touches from standard input, one a line: `surface,x,y,z[,i,j,k]` with or without a header, or JSON objects
/// `{"surface": "plane", "at": [x, y, z]}`; `undo`, or `{"undo": true}`, takes the last one back. Answers each line at once:
/// a line of text, or with --format json an object. A line that is wrong is told and skipped; nothing is lost. Touches of the
/// measurement count as made.
/// Before the frame is known, motions and places are told for the frame that --near gives; without one as if each touch had
/// been made where it was asked for. Ends with exit status 0 and the frame when it is accepted and the target met; with 1
/// when the input ends before that.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref guide examples/cube.toml")]
pub(crate) struct Args {
    #[command(flatten)]
    measurement: MeasurementArgs,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    near: NearArgs,
    #[command(flatten)]
    planning: PlanningArgs,
    /// Expanded uncertainty (95 %) along the worst direction that is wanted at every point of use [default: any frame that is
    /// accepted]
    #[arg(long, value_name = "U", value_parser = length, allow_negative_numbers = true)]
    target: Option<f64>,
    /// Form of the answers: lines of text, or a JSON object a line
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// How things may stand: without a frame, with one, refused by the solver, or at a line that cannot be used.
const STATES: [&str; 13] = [
    "free",
    "located",
    "done",
    "ambiguous",
    "degenerate",
    "inconsistent",
    "not-converged",
    "not-validated",
    "invalid-input",
    "too-few-touches",
    "unsupported",
    "error",
    "unfinished",
];

/// The answer to a line. What does not exist is `null` or empty.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Answer {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// The line that is answered, from 1; `null` before the first and after the last.
    pub(crate) line: Option<usize>,
    /// How things stand.
    #[schemars(extend("enum" = STATES))]
    pub(crate) state: &'static str,
    /// How many touches there are.
    pub(crate) touches: usize,
    /// The last of them, from 0, and its surface.
    pub(crate) touch: Option<usize>,
    /// The surface of that touch.
    pub(crate) surface: Option<String>,
    /// What the line took back.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) undone: Option<Undone>,
    /// Motions to determine, and which of them are still free.
    pub(crate) unknowns: usize,
    /// Motions that are still free, in words.
    pub(crate) free: Vec<String>,
    /// Touches that the fixture still needs, in words.
    pub(crate) missing: Option<String>,
    /// At the points of use.
    pub(crate) points: Vec<PointRecord>,
    /// Largest expanded uncertainty over these.
    pub(crate) expanded: Option<f64>,
    /// The expanded uncertainty that is wanted.
    pub(crate) target: Option<f64>,
    /// Unit of every length.
    #[schemars(schema_with = "schema::units")]
    pub(crate) units: &'static str,
    /// The touch to make next.
    pub(crate) next: Option<NextTouch>,
    /// Why there is no frame, or what is wrong with the line.
    pub(crate) error: Option<ErrorDetails>,
    /// What the user should know.
    pub(crate) warnings: Vec<WarningRecord>,
    /// The result, as of `locate`.
    pub(crate) solution: Option<SolutionRecord>,
}

/// A touch that was taken back; nothing where there was none.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Undone {
    /// Which it was, from 0.
    pub(crate) touch: Option<usize>,
    /// Its surface.
    pub(crate) surface: Option<String>,
}

/// What there is so far.
struct Session<'a> {
    setup: &'a Setup,
    planner: Planner<'a>,
    near: Option<Frame>,
    target: Option<f64>,
    records: Vec<TouchRecord>,
    touches: Vec<Touch>,
    /// Where each touch is taken to be while no frame is known, in fixture coordinates.
    assumed: Vec<Touch>,
    /// Where the next touch was asked for.
    asked: Option<Next>,
}

/// How lines are read.
enum Lines {
    /// Not known before the first.
    Unknown,
    Table(Box<TableReader>),
    Json,
}

/// A line as it is meant.
enum Line {
    /// Blank, a comment or a header.
    Nothing,
    Undo,
    Touch(Box<TouchRecord>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct UndoLine {
    undo: bool,
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        if self.measurement.reads_stdin() {
            let message = "standard input gives the touches, so the measurement cannot come from there";
            return Err(InputError::new("invalid-input", message).with_help("give it as a file").into());
        }
        let solver = self.solver.build(registry, &[])?;
        let near = self.near.frame()?;
        let setup = self.measurement.load(registry)?;
        if self.target.is_some() {
            can_aim(&setup)?;
        }
        let planner = self.planning.planner(&setup, &*solver)?;
        let mut session = Session {
            setup: &setup,
            planner,
            near,
            target: self.target,
            records: Vec::new(),
            touches: Vec::new(),
            assumed: Vec::new(),
            asked: None,
        };
        if setup.has_touches() {
            for record in &setup.touches()?.records {
                session.add(record.clone())?;
            }
        }
        self.converse(&mut session)
    }

    fn converse(&self, session: &mut Session<'_>) -> Result<Output, Failure> {
        let mut answers = Answers::new();
        let mut answer = session.answer(None)?;
        let mut lines = Lines::Unknown;
        let mut input = io::stdin().lock();
        let mut said = false;
        for number in 1.. {
            if answer.state == "done" {
                return Ok(self.last(&answer));
            }
            if !said && !answers.say(&self.told(&answer))? {
                return Ok(Output::nothing());
            }
            said = true;
            let Some(text) = read_line(&mut input)? else { break };
            answer = match lines.read(number, &text, session) {
                Ok(Line::Nothing) => continue,
                Ok(Line::Undo) => {
                    let undone = Some(session.undo());
                    Answer { undone, ..session.answer(Some(number))? }
                }
                Ok(Line::Touch(record)) => match session.add(*record) {
                    Ok(()) => session.answer(Some(number))?,
                    Err(error) => session.wrong(number, &error),
                },
                Err(error) => session.wrong(number, &error),
            };
            said = false;
        }
        // Where things stand, not what was wrong with the last line.
        let answer = session.answer(None)?;
        let unfinished = Answer { line: None, state: "unfinished", ..answer };
        let printed = self.told(&unfinished) + "\n";
        Ok(Output::bytes(printed).with_status(1))
    }

    fn told(&self, answer: &Answer) -> String {
        match self.format {
            // Keys are strings and numbers are plain, so that writing to memory cannot fail.
            Format::Json => serde_json::to_string(answer).unwrap_or_default(),
            Format::Text => text::answer(answer),
        }
    }

    /// The answer with the frame.
    fn last(&self, answer: &Answer) -> Output {
        let mut printed = self.told(answer) + "\n";
        if let (Format::Text, Some(solution)) = (self.format, &answer.solution) {
            printed += &("\n".to_owned() + &text::solution(solution, Look::of(&io::stdout())));
        }
        Output::bytes(printed)
    }
}

impl Lines {
    /// What a line means.
    fn read(&mut self, number: usize, text: &str, session: &Session<'_>) -> Result<Line, InputError> {
        let text = text.trim();
        if text.is_empty() || text.starts_with('#') {
            return Ok(Line::Nothing);
        }
        if text.eq_ignore_ascii_case(UNDO) {
            return Ok(Line::Undo);
        }
        if text.starts_with('{') {
            *self = Self::Json;
        } else if !matches!(self, Self::Table(_)) {
            let surfaces = session.setup.fixture.surfaces();
            let names: Vec<&str> = surfaces.iter().map(|surface| surface.name.as_str()).collect();
            // Names of columns, and no numbers.
            let fields = || text.split([',', ';', '\t']).map(str::trim);
            let is_header = fields().all(|field| field.replace(',', ".").parse::<f64>().is_err());
            let header = if is_header { text } else { HEADERS[usize::from(fields().count() > 4)] };
            *self = Self::Table(Box::new(
                TableReader::of_rows(header, INPUT, &names)?.in_units(session.setup.measurement.units),
            ));
            if is_header {
                return Ok(Line::Nothing);
            }
        }
        let record = match self {
            Self::Table(table) => table.row(number, text)?,
            _ if serde_json::from_str::<UndoLine>(text).is_ok_and(|line| line.undo) => return Ok(Line::Undo),
            _ => TouchRecord::from_json(INPUT, number, text)?,
        };
        Ok(Line::Touch(Box::new(record)))
    }
}

impl Session<'_> {
    /// Takes a touch to those that are there.
    fn add(&mut self, record: TouchRecord) -> Result<(), InputError> {
        let touch = record
            .touch(&*self.setup.fixture)
            .map_err(|error| InputError::from(error).with_key("surface"))?;
        let touches = [self.touches.as_slice(), &[touch]].concat();
        // Its numbers make sense beside the others'.
        Problem::new(&*self.setup.fixture, &touches, self.planner.probe)?;
        let count = self.touches.iter().filter(|other| other.surface == touch.surface).count();
        let asked = self.asked.filter(|asked| asked.surface == touch.surface).map(|asked| asked.contact);
        let contact = asked.unwrap_or_else(|| self.planner.spread(touch.surface, count));
        let tip =
            self.setup.fixture.surfaces()[touch.surface].tip_center(&contact, self.planner.probe.tip_radius);
        self.assumed.push(Touch { at: tip, approach: None, ..touch });
        self.touches = touches;
        self.records.push(record);
        Ok(())
    }

    fn undo(&mut self) -> Undone {
        self.touches.pop();
        self.assumed.pop();
        let surface = self.records.pop().map(|record| record.surface);
        Undone { touch: surface.is_some().then_some(self.touches.len()), surface }
    }

    /// What there is to say of a line that cannot be used; all is as before.
    fn wrong(&self, number: usize, error: &InputError) -> Answer {
        Answer {
            line: Some(number),
            state: "error",
            error: Some(ErrorRecord::from(error).error),
            ..self.blank()
        }
    }

    fn blank(&self) -> Answer {
        Answer {
            schema: SCHEMA,
            line: None,
            state: "free",
            touches: self.touches.len(),
            touch: self.touches.len().checked_sub(1),
            surface: self.records.last().map(|record| record.surface.clone()),
            undone: None,
            unknowns: 6 - self.setup.fixture.freedom().count(),
            free: Vec::new(),
            missing: None,
            points: Vec::new(),
            expanded: None,
            target: self.target,
            units: self.setup.measurement.units.name(),
            next: None,
            error: None,
            warnings: Vec::new(),
            solution: None,
        }
    }

    /// Where things stand.
    fn answer(&mut self, line: Option<usize>) -> Result<Answer, Failure> {
        let fixture = &*self.setup.fixture;
        let mut answer = Answer { line, ..self.blank() };
        let touched = self.touches.iter().map(|touch| touch.surface);
        let counts = touches_per_surface(fixture.surfaces().len(), touched);
        answer.missing = fixture.requirement().missing(&counts, fixture.surfaces());
        if answer.missing.is_some() {
            self.still_free(&mut answer, &nominal_counts(self.setup));
            return Ok(answer);
        }
        let touches = self.touches.clone();
        let problem = Problem::new(fixture, &touches, self.planner.probe).map_err(InputError::from)?;
        let problem = self.near.map_or(problem, |frame| problem.near(frame));
        match self.planner.solver.solve(&problem) {
            Ok(solution) => self.located(&mut answer, &solution)?,
            Err(error) => {
                answer.state = error.code();
                let record = ErrorRecord::of_refusal(&error, self.setup.measurement.units, &self.records);
                answer.error = Some(record.error);
                let frames = match &error {
                    SolveError::Ambiguous(_) => self.planner.surviving(&problem, &error),
                    _ => Vec::new(),
                };
                if let Ok(next) = self.planner.next_apart(&touches, &frames) {
                    answer.next = Some(NextTouch::new(&self.planner, &next, frames.first(), frames.len()));
                    self.asked = Some(next);
                } else {
                    let more: Vec<usize> =
                        counts.iter().map(|count| count + usize::from(*count > 0)).collect();
                    self.still_free(&mut answer, &more);
                }
            }
        }
        Ok(answer)
    }

    /// What is still free, and the next touch toward these counts.
    fn still_free(&mut self, answer: &mut Answer, counts: &[usize]) {
        let fixture = &*self.setup.fixture;
        // With no frame expected, each touch is taken to be where it was asked for, and the fixture along its own axes.
        let (frame, touches) = match &self.near {
            Some(near) => (*near, &self.touches),
            None => (Frame::identity(), &self.assumed),
        };
        if let Ok(problem) = Problem::new(fixture, touches, self.planner.probe) {
            let free = free_motions(&problem, &frame);
            answer.free = free.iter().map(ToString::to_string).collect();
        }
        self.asked = self.planner.next_toward(counts, touches, &frame).ok();
        answer.next = self.asked.map(|next| NextTouch::new(&self.planner, &next, self.near.as_ref(), 0));
    }

    /// How sure the frame is, and whether that is enough.
    fn located(&mut self, answer: &mut Answer, solution: &Solution) -> Result<(), Failure> {
        let setup = self.setup;
        let points = &self.planner.points;
        answer.state = "located";
        if let Some(covariance) = &solution.covariance {
            let uncertainties = worst_case(&covariance.matrix, &solution.frame, points);
            let worst = uncertainties.iter().copied().fold(0.0, f64::max);
            answer.expanded = Some(coverage_factor() * worst);
            let told = points.iter().zip(uncertainties);
            let told = told.map(|(at, u)| PointRecord {
                at: (*at).into(),
                u: Some(u),
                u_over_sigma: u / covariance.sigma,
            });
            answer.points = told.collect();
        }
        answer.warnings = solution.warnings.iter().map(WarningRecord::from).collect();
        let met = |target: f64| answer.expanded.is_some_and(|expanded| expanded <= target);
        if self.target.is_none_or(met) {
            answer.state = "done";
            let context = Context {
                kind: setup.fixture.kind(),
                parameters: setup.fixture.parameters(),
                units: setup.measurement.units,
                probe: &setup.measurement.probe,
                touches: &self.records,
            };
            answer.solution = Some(SolutionRecord::new(&context, solution));
            self.asked = None;
        } else {
            let next = self.planner.next(&self.touches, &solution.frame)?;
            answer.next = Some(NextTouch::new(&self.planner, &next, Some(&solution.frame), 1));
            self.asked = Some(next);
        }
        Ok(())
    }
}

/// The next line; `None` at the end.
fn read_line(input: &mut impl BufRead) -> Result<Option<String>, Failure> {
    /// The longest that is read, in bytes: more is not a touch.
    const LONGEST: u64 = 1 << 16;
    let mut bytes = Vec::new();
    let read = input.by_ref().take(LONGEST).read_until(b'\n', &mut bytes);
    let length = read.map_err(|error| {
        InputError::new("unreadable", format!("cannot read {INPUT}: {error}")).with_file(INPUT)
    })?;
    // What is not text is no touch: the line is told as wrong.
    Ok((length > 0).then(|| String::from_utf8_lossy(&bytes).into_owned()))
}
