//! A panic ends at the boundary.
#![allow(clippy::unwrap_used, unsafe_code)] // A test stops at what is not as expected; it is the C caller, too.

use std::{
    ffi::{CStr, c_char},
    mem::MaybeUninit,
};

use touchref::{FixturePlugin, fixtures::cube, register_fixture};
use touchref_c::{
    Error, Fixture, TOUCHREF_INTERNAL, TOUCHREF_OK, Text, touchref_error_code, touchref_error_json,
    touchref_error_message, touchref_fixture_new,
};

static FAULTY: FixturePlugin = FixturePlugin {
    name: "faulty",
    origin: module_path!(),
    parameters: &[],
    build: |_| panic!("no such luck"),
    ..cube::PLUGIN
};
register_fixture!(FAULTY);

fn made(kind: &CStr, parameters: &CStr) -> (i32, Option<Box<Fixture>>, Option<Box<Error>>) {
    let (mut fixture, mut error) = (MaybeUninit::new(None), MaybeUninit::new(None));
    let text = |text| Text::from(Some(text));
    let status =
        touchref_fixture_new(text(kind), text(parameters), text(c"mm"), Some(&mut fixture), Some(&mut error));
    // SAFETY: both held a value before, and every call writes one.
    unsafe { (status, fixture.assume_init(), error.assume_init()) }
}

fn told(text: *const c_char) -> String {
    // SAFETY: it ends with a zero byte, and its error lives.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned()
}

#[test]
fn a_panic_is_an_error_and_the_library_works_on() {
    let (status, fixture, error) = made(c"faulty", c"");
    let error = error.as_deref();
    assert_eq!((status, fixture.is_none()), (TOUCHREF_INTERNAL, true));
    assert_eq!(told(touchref_error_code(error)), "internal");
    assert!(told(touchref_error_message(error)).contains("no such luck"));
    let json: serde_json::Value = serde_json::from_str(&told(touchref_error_json(error))).unwrap();
    assert_eq!(json["schema"], "touchref.error/1");

    let (status, fixture, error) = made(c"cube", c"edge = 80");
    assert_eq!((status, fixture.is_some(), error.is_none()), (TOUCHREF_OK, true, true));
}
