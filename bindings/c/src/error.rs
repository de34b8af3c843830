//! Why there is no result, and the boundary that no panic crosses.

use std::{
    any::Any,
    ffi::CString,
    mem::MaybeUninit,
    panic::{AssertUnwindSafe, catch_unwind},
};

use touchref::{
    DialectError, RegistryError,
    io::{ErrorRecord, InputError, write::json},
    locate,
};

use crate::{
    c_string,
    foreign::null,
    interface::{Status, TOUCHREF_INTERNAL, TOUCHREF_OK},
};

/// Why a call gives no result.
#[derive(Debug)]
pub struct Error {
    pub(crate) status: Status,
    pub(crate) code: CString,
    pub(crate) message: CString,
    pub(crate) help: CString,
    /// `touchref.error/1`.
    pub(crate) json: CString,
}

/// A place of the caller for a handle that is handed out; it may hold anything before.
pub(crate) type Place<'a, T> = Option<&'a mut MaybeUninit<Option<Box<T>>>>;

impl Error {
    fn new(status: Status, record: &ErrorRecord) -> Self {
        let details = &record.error;
        Self {
            status,
            code: c_string(&details.code),
            message: c_string(&details.message),
            help: c_string(&details.help),
            json: c_string(&json(record)),
        }
    }

    /// A panic: a fault of this library or of a plugin.
    fn internal(panic: &(dyn Any + Send)) -> Self {
        let words = panic.downcast_ref::<String>().map(String::as_str);
        let words = words.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        let record = ErrorRecord::new(
            "internal",
            format!("a fault in touchref or in one of its plugins: {words}"),
            "report it with the input that shows it; the library can be used on",
        );
        Self::new(TOUCHREF_INTERNAL, &record)
    }
}

impl From<locate::Failure> for Error {
    fn from(failure: locate::Failure) -> Self {
        Self::new(failure.status().into(), &failure.record())
    }
}

impl From<InputError> for Error {
    fn from(error: InputError) -> Self {
        locate::Failure::from(error).into()
    }
}

impl From<RegistryError> for Error {
    fn from(error: RegistryError) -> Self {
        InputError::from(error).into()
    }
}

impl From<DialectError> for Error {
    fn from(error: DialectError) -> Self {
        locate::Failure::from(error).into()
    }
}

/// Does the work of a call, and puts what comes of it where the caller wants it: the result or the error, and null in
/// the other place. `name` is that of the result, which must have a place. No panic leaves it.
pub(crate) fn guarded<T>(
    name: &str,
    result: Place<'_, T>,
    error: Place<'_, Error>,
    work: impl FnOnce() -> Result<T, Error>,
) -> Status {
    // Nothing that lives on is changed by the work, so that nothing is left half done.
    let work = || if result.is_some() { work() } else { Err(null(name).into()) };
    let outcome = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(Error::internal(&*panic)));
    let (value, failure) = match outcome {
        Ok(value) => (Some(Box::new(value)), None),
        Err(failure) => (None, Some(Box::new(failure))),
    };
    let status = failure.as_ref().map_or(TOUCHREF_OK, |failure| failure.status);
    if let Some(place) = result {
        place.write(value);
    }
    if let Some(place) = error {
        place.write(failure);
    }
    status
}
