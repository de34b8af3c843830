//! How a method is run: here, or by another program that is asked to.

use std::{
    cell::RefCell,
    fs,
    hint::black_box,
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
    time::Duration,
};

use touchref::Frame;

use super::set::{self, Set};

/// A method over the problems of one set.
pub(crate) trait Run {
    /// Nanoseconds that the first `count` problems take, `repeats` times over.
    fn nanoseconds(&mut self, count: usize, repeats: usize) -> f64;
    /// The frames of the first `count` problems.
    fn frames(&mut self, count: usize) -> Vec<Option<Frame>>;
}

/// Nanoseconds of the processor that something takes: what else the machine does is not counted.
pub(crate) fn nanoseconds(work: impl FnOnce()) -> f64 {
    let start = processor_time().as_secs_f64();
    work();
    (processor_time().as_secs_f64() - start) * 1e9
}

/// The time that this process has had.
#[cfg(unix)]
fn processor_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::try_from(time).unwrap()
}

/// Elsewhere, the time that has passed.
#[cfg(not(unix))]
fn processor_time() -> Duration {
    static START: std::sync::LazyLock<std::time::Instant> = std::sync::LazyLock::new(std::time::Instant::now);
    START.elapsed()
}

/// A method of this program: from the number of a problem to its frame.
pub(crate) struct Each<F>(pub(crate) F);

impl<F: Fn(usize) -> Option<Frame>> Run for Each<F> {
    fn nanoseconds(&mut self, count: usize, repeats: usize) -> f64 {
        nanoseconds(|| {
            for _ in 0..repeats {
                for index in 0..count {
                    black_box((self.0)(black_box(index)));
                }
            }
        })
    }

    fn frames(&mut self, count: usize) -> Vec<Option<Frame>> {
        (0..count).map(&self.0).collect()
    }
}

/// Another program that solves what is asked of it.
///
/// It gets a folder as its argument, and first tells its versions in a line. Asked by a line `METHOD SET COUNT REPEATS` it
/// solves the first problems of the folder's file `SET.f64` with the method so many times over, writes their frames to
/// `METHOD.f64` and answers with a line: the nanoseconds of the processor that solving took. What these files hold, [`Set::write`] tells;
/// numbers of a frame that was not found are not numbers.
pub(crate) struct Program {
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    folder: PathBuf,
    pub(crate) versions: String,
}

impl Program {
    /// Starts it; says why where that cannot be.
    pub(crate) fn start(command: &mut Command, folder: &Path) -> Result<Self, String> {
        let command = command.arg(folder).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().map_err(|error| error.to_string())?;
        let (requests, answers) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let mut program = Self {
            child,
            requests,
            answers: BufReader::new(answers),
            folder: folder.to_owned(),
            versions: String::new(),
        };
        program.versions = program.line()?;
        Ok(program)
    }

    fn line(&mut self) -> Result<String, String> {
        let mut line = String::new();
        match self.answers.read_line(&mut line) {
            Ok(0) => Err("it ended without an answer".to_owned()),
            Ok(_) => Ok(line.trim().to_owned()),
            Err(error) => Err(error.to_string()),
        }
    }

    fn solve(&mut self, method: &str, set: &str, count: usize, repeats: usize) -> Result<f64, String> {
        writeln!(self.requests, "{method} {set} {count} {repeats}").map_err(|error| error.to_string())?;
        let answer = self.line()?;
        answer.parse().map_err(|_| format!("it answered `{answer}`"))
    }
}

impl Drop for Program {
    /// It goes before the folder does.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A method of another program.
pub(crate) struct Asked<'a> {
    pub(crate) program: &'a RefCell<Program>,
    pub(crate) method: &'static str,
    pub(crate) set: &'a Set,
}

impl Run for Asked<'_> {
    fn nanoseconds(&mut self, count: usize, repeats: usize) -> f64 {
        let answer = self.program.borrow_mut().solve(self.method, self.set.name, count, repeats);
        answer.unwrap_or_else(|why| panic!("{} with {}: {why}", self.method, self.set.name))
    }

    fn frames(&mut self, count: usize) -> Vec<Option<Frame>> {
        self.nanoseconds(count, 1);
        let bytes = fs::read(set::file(&self.program.borrow().folder, self.method)).unwrap();
        let numbers: Vec<f64> =
            bytes.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect();
        numbers.chunks_exact(12).map(set::frame).collect()
    }
}
