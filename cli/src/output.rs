//! The one place that prints.

use std::{
    cell::Cell,
    fs::File,
    io::{self, IsTerminal, Write},
    ops::Deref,
    path::Path,
    sync::mpsc::{RecvTimeoutError, Sender, channel},
    thread::{self, JoinHandle},
    time::Duration,
};

use anstream::AutoStream;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use tempfile::NamedTempFile;
use touchref::io::{solution::WarningRecord, write::json};

use crate::{
    args::Format,
    failure::Failure,
    text::{self, Look},
};

/// Writes a result as it comes to be; nothing is held in memory.
type Writer = Box<dyn FnOnce(&mut dyn Write) -> io::Result<()>>;

/// What a subcommand prints.
pub(crate) struct Output {
    result: Writer,
    /// For standard error, one line each.
    notes: Vec<String>,
    /// The exit status.
    status: u8,
}

/// What is printed on standard error besides errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Verbosity {
    /// Nothing.
    Quiet,
    /// Warnings, and progress on a terminal.
    #[default]
    Normal,
    /// How frames were found, too.
    Verbose,
}

thread_local! {
    /// That of the call, which runs on one thread.
    static VERBOSITY: Cell<Verbosity> = const { Cell::new(Verbosity::Normal) };
}

/// Decides what is printed from now on.
pub(crate) fn set_verbosity(verbosity: Verbosity) {
    VERBOSITY.set(verbosity);
}

/// What is printed.
pub(crate) fn verbosity() -> Verbosity {
    VERBOSITY.get()
}

/// Lines that are printed at once, for work that answers as it is asked.
pub(crate) struct Answers(AutoStream<io::Stdout>);

impl Answers {
    pub(crate) fn new() -> Self {
        Self(AutoStream::auto(io::stdout()))
    }

    /// Prints a line; `false` where nobody reads any more.
    pub(crate) fn say(&mut self, line: &str) -> Result<bool, Failure> {
        match writeln!(self.0, "{line}").and_then(|()| self.0.flush()) {
            Ok(()) => Ok(true),
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(false),
            Err(error) => Err(Failure::writing("to standard output", &error)),
        }
    }
}

impl Output {
    /// A result that writes itself.
    pub(crate) fn stream(result: impl FnOnce(&mut dyn Write) -> io::Result<()> + 'static) -> Self {
        Self { result: Box::new(result), notes: Vec::new(), status: 0 }
    }

    /// A result that is there already.
    pub(crate) fn bytes(result: impl Into<Vec<u8>>) -> Self {
        let result = result.into();
        Self::stream(move |output| output.write_all(&result))
    }

    /// No result.
    pub(crate) fn nothing() -> Self {
        Self::bytes([])
    }

    /// A result for programs.
    pub(crate) fn json(record: &impl Serialize) -> Self {
        Self::bytes(json(record))
    }

    /// A result in the form that was asked for. Its warnings are in the record for programs, and for people on standard error.
    pub(crate) fn in_form<R: Serialize>(
        format: Format,
        record: &R,
        warnings: &[WarningRecord],
        text: impl FnOnce(&R, Look) -> String,
    ) -> Self {
        match format {
            Format::Json => Self::json(record),
            Format::Text => Self::bytes(text(record, Look::of(&io::stdout())))
                .with_notes(warnings.iter().map(|warning| format!("warning: {}", warning.message))),
        }
    }

    /// The same with another exit status than 0.
    pub(crate) fn with_status(self, status: u8) -> Self {
        Self { status, ..self }
    }

    /// Adds lines for standard error.
    pub(crate) fn with_notes(mut self, notes: impl IntoIterator<Item = String>) -> Self {
        self.notes.extend(notes);
        self
    }
}

/// Prints what a subcommand came to, and returns the exit status.
pub(crate) fn print(outcome: Result<Output, Failure>, json_errors: bool) -> u8 {
    let output = match outcome {
        Ok(output) => output,
        Err(failure) if failure.is_help() => {
            // clap colours and pages its own help; it knows the terminal as well as anyone.
            let Failure::Call(help) = &failure else { return failure.status() };
            return after_writing(help.print(), failure.status());
        }
        Err(failure) if json_errors => Output::json(&failure.record()).with_status(failure.status()),
        Err(failure) => {
            complain(&failure);
            return failure.status();
        }
    };
    let mut stdout = AutoStream::auto(io::stdout().lock());
    let written = (output.result)(&mut stdout).and_then(|()| stdout.flush());
    for line in output.notes {
        note_on_the_way(|look| text::note(&line, look));
    }
    after_writing(written, output.status)
}

/// A bar on standard error, gone when it is dropped, whatever came of the work.
pub(crate) struct Progress(ProgressBar);

impl Deref for Progress {
    type Target = ProgressBar;

    fn deref(&self) -> &ProgressBar {
        &self.0
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// A bar for so many steps of long work, on a terminal.
pub(crate) fn progress(steps: u64) -> Progress {
    Progress(bar(Some(steps), "{wide_bar} {pos} of {len}, {eta} left"))
}

/// The same for work of which nobody knows how much there is.
pub(crate) fn progress_without_end() -> Progress {
    Progress(bar(None, "{spinner} {pos}, {elapsed}"))
}

/// A bar in this style; hidden where nobody could see it, or wants to.
fn bar(steps: Option<u64>, template: &str) -> ProgressBar {
    // A dumb terminal cannot go back on its line.
    let dumb = std::env::var_os("TERM").is_none_or(|kind| kind == "dumb");
    let shown = io::stderr().is_terminal() && !dumb && verbosity() != Verbosity::Quiet;
    let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(steps, target);
    // The template is right: what cannot be shown only looks otherwise.
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("##-").tick_chars("|/-\\ "));
    }
    bar
}

/// A sign of life for work whose steps nobody can count, from when it takes long until it is dropped.
pub(crate) struct Working(Option<(Sender<()>, JoinHandle<()>)>);

impl Drop for Working {
    fn drop(&mut self) {
        if let Some((stop, thread)) = self.0.take() {
            drop(stop);
            // It has cleared its line when it has ended.
            let _ = thread.join();
        }
    }
}

/// A sign of life for such work, on a terminal.
pub(crate) fn working(what: &'static str) -> Working {
    /// Work that is done by then needs none.
    const PATIENCE: Duration = Duration::from_millis(500);
    const TICK: Duration = Duration::from_millis(100);
    let bar = bar(None, "{spinner} {msg}, {elapsed}").with_message(what);
    if bar.is_hidden() {
        return Working(None);
    }
    let (stop, stopped) = channel::<()>();
    let thread = thread::spawn(move || {
        let mut wait = PATIENCE;
        while stopped.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
            bar.tick();
            wait = TICK;
        }
        bar.finish_and_clear();
    });
    Working(Some((stop, thread)))
}

/// Writes to standard error, unless nothing but errors is wanted there.
pub(crate) fn note(text: &str) {
    if verbosity() != Verbosity::Quiet {
        write_error(text);
    }
}

/// The same, with a line end, in the look of standard error.
pub(crate) fn note_on_the_way(text: impl FnOnce(Look) -> String) {
    note(&(text(Look::of(&io::stderr())) + "\n"));
}

/// Tells an error.
fn complain(failure: &Failure) {
    write_error(&text::failure(failure, Look::of(&io::stderr())));
}

/// There is nobody left to tell when this fails.
fn write_error(text: &str) {
    let _ = AutoStream::auto(io::stderr().lock()).write_all(text.as_bytes());
}

fn after_writing(written: io::Result<()>, status: u8) -> u8 {
    match written {
        Ok(()) => status,
        // `touchref ... | head` has read enough: no failure of this program.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => status,
        Err(error) => {
            complain(&Failure::writing("to standard output", &error));
            2
        }
    }
}

/// Writes a file whole or not at all: beside it first, then in its place.
pub(crate) fn write_file(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    let whole = || -> io::Result<()> {
        let mut file = NewFile::create(path)?;
        let mut buffer = io::BufWriter::new(file.writer());
        write(&mut buffer)?;
        buffer.flush()?;
        drop(buffer);
        file.keep()
    };
    whole().map_err(|error| Failure::writing(path.display(), &error))
}

/// A file that is whole or not there at all: it takes its place when it is kept.
pub(crate) struct NewFile<'p> {
    path: &'p Path,
    content: Content,
}

enum Content {
    /// A pipe or a device cannot be replaced, and keeps no half of a file.
    InPlace(File),
    Beside(NamedTempFile),
}

impl<'p> NewFile<'p> {
    pub(crate) fn create(path: &'p Path) -> io::Result<Self> {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let content = if path.metadata().is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir()) {
            Content::InPlace(File::create(path)?)
        } else {
            Content::Beside(new_file(folder)?)
        };
        Ok(Self { path, content })
    }

    /// To write to, best in large pieces.
    pub(crate) fn writer(&mut self) -> &mut File {
        match &mut self.content {
            Content::InPlace(file) => file,
            Content::Beside(file) => file.as_file_mut(),
        }
    }

    /// Puts it in its place.
    pub(crate) fn keep(self) -> io::Result<()> {
        if let Content::Beside(file) = self.content {
            file.persist(self.path)?;
        }
        Ok(())
    }
}

/// A temporary file that others may read once it is in place, as far as the user's mask allows.
#[cfg(unix)]
fn new_file(folder: &Path) -> io::Result<NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    tempfile::Builder::new().permissions(std::fs::Permissions::from_mode(0o666)).tempfile_in(folder)
}

#[cfg(not(unix))]
fn new_file(folder: &Path) -> io::Result<NamedTempFile> {
    NamedTempFile::new_in(folder)
}

impl Look {
    /// How to print to a stream: boxes and colours on a terminal that has them, plain ASCII elsewhere.
    pub(crate) fn of(stream: &impl IsTerminal) -> Self {
        if stream.is_terminal() {
            let columns = terminal_size::terminal_size().map_or(80, |(width, _)| usize::from(width.0));
            Self {
                terminal: true,
                unicode: supports_unicode::supports_unicode(),
                width: columns.clamp(40, 110),
            }
        } else {
            Self::PLAIN
        }
    }
}
