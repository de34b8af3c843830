//! Waiting for another thread in a way that the user can interrupt.

use std::{
    sync::mpsc::{Receiver, RecvTimeoutError, channel},
    thread,
    time::Duration,
};

use pyo3::{exceptions::PyRuntimeError, prelude::*};

/// How long an interrupt may go unnoticed: too short to be felt.
const UNNOTICED: Duration = Duration::from_millis(20);

/// What `receiver` receives next; other threads of Python run meanwhile.
///
/// # Errors
/// What a signal raises, as `KeyboardInterrupt`; `RuntimeError` where the thread at work has ended: a fault of touchref.
pub(crate) fn wait<T: Send>(py: Python<'_>, receiver: &mut Receiver<T>) -> PyResult<T> {
    py.detach(move || {
        loop {
            match receiver.recv_timeout(UNNOTICED) {
                Ok(answer) => return Ok(answer),
                Err(RecvTimeoutError::Timeout) => {
                    #[expect(
                        clippy::redundant_closure_for_method_calls,
                        reason = "the method has one lifetime"
                    )]
                    Python::attach(|py| py.check_signals())?;
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(PyRuntimeError::new_err(
                        "touchref failed; please report how that came about",
                    ));
                }
            }
        }
    })
}

/// Does some work on a thread of its own; where the user interrupts, its result is not waited for.
///
/// # Errors
/// As [`wait`].
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (sender, mut receiver) = channel();
    thread::spawn(move || {
        // Nobody receives after an interrupt.
        let _ = sender.send(work());
    });
    wait(py, &mut receiver)
}
