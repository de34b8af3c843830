//! Memory of the caller, read: the only unsafe operations of this crate.
//!
//! What Rust's types can say of a pointer is said by them: `Option<&T>` is a pointer that may be null, `Option<Box<T>>` a
//! handle that is handed back, `Option<&mut MaybeUninit<T>>` a place that may hold nothing yet. Only where a string ends
//! and how long an array is has to be taken on trust from the caller. The header states what the caller promises:
//!
//! * a pointer is null or points to what its type says, which nobody writes to during the call;
//! * a string ends with a zero byte, an array is as long as its count says;
//! * a handle comes from this library and is handed back once.
#![allow(unsafe_code)]

use std::{
    ffi::{CStr, c_char},
    marker::PhantomData,
    slice,
};

use touchref::io::InputError;

/// A string of the caller: null, or ended by a zero byte and unchanged while `'a` lasts. Safe code makes no other.
///
/// cbindgen:transparent-typedef
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct Text<'a>(*const c_char, PhantomData<&'a CStr>);

impl<'a> From<Option<&'a CStr>> for Text<'a> {
    fn from(text: Option<&'a CStr>) -> Self {
        Self(text.map_or(std::ptr::null(), CStr::as_ptr), PhantomData)
    }
}

impl<'a> Text<'a> {
    /// What it says, `None` where it is null; `what` names it in messages.
    ///
    /// # Errors
    /// `invalid-input` for what is not UTF-8.
    pub(crate) fn optional(self, what: &str) -> Result<Option<&'a str>, InputError> {
        if self.0.is_null() {
            return Ok(None);
        }
        // SAFETY: not null, and by what the type says it ends with a zero byte and stays as it is while `'a` lasts.
        let bytes = unsafe { CStr::from_ptr(self.0) };
        bytes.to_str().map(Some).map_err(|error| {
            let message = format!("{what} is not UTF-8 text from byte {} on", error.valid_up_to());
            InputError::new("invalid-input", message).with_key(what)
        })
    }

    /// The same of a string that must be given.
    ///
    /// # Errors
    /// `invalid-input` for null, too.
    pub(crate) fn required(self, what: &str) -> Result<&'a str, InputError> {
        self.optional(what)?.ok_or_else(|| null(what))
    }
}

/// The error of a null pointer where there must be none.
pub(crate) fn null(what: &str) -> InputError {
    InputError::new("invalid-input", format!("{what} is NULL")).with_key(what)
}

/// An array of the caller, which may be null where it is empty; `what` names it in messages.
///
/// # Safety
/// Where `first` is not null, `count` elements that nobody changes while `'a` lasts begin there.
///
/// # Errors
/// `invalid-input` for a null pointer, one that is not aligned, and a length that no memory has.
pub(crate) unsafe fn array<'a, T>(first: *const T, count: usize, what: &str) -> Result<&'a [T], InputError> {
    let wrong =
        |problem: String| Err(InputError::new("invalid-input", format!("{what} {problem}")).with_key(what));
    if count == 0 {
        return Ok(&[]);
    }
    if first.is_null() {
        return wrong(format!("is NULL, but its count is {count}"));
    }
    if !first.is_aligned() {
        return wrong("is not aligned as its type asks".to_owned());
    }
    if count > isize::MAX.unsigned_abs() / size_of::<T>() {
        return wrong(format!("cannot have {count} elements"));
    }
    // SAFETY: not null, aligned and of a size that memory can have; the rest is what the caller promises.
    Ok(unsafe { slice::from_raw_parts(first, count) })
}
