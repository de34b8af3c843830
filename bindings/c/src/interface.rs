//! The functions and types of the C interface, from which `include/touchref.h` is made: what is documented here is what
//! its reader sees.
//!
//! Each function answers null for any pointer, and none prints. What can fail in more than one way works in [`guarded`].
#![allow(clippy::doc_markdown)] // In a header the names of C are no code among words.
#![allow(unsafe_code)] // For `#[unsafe(no_mangle)]`, and for the one array, which `foreign` reads.

use std::{
    ffi::{CStr, CString, c_char, c_int},
    mem::MaybeUninit,
    ptr,
};

use crate::{
    error::{Error, guarded},
    fixture::{self, Fixture},
    foreign::{Text, array, null},
    solution::{Literal, Solution, locate},
};

/// What came of a call: one of the numbers above. 0 to 2 are the exit statuses of the command line.
pub type Status = c_int;

/// It is done; of touchref_locate: a frame that passed its checks.
pub const TOUCHREF_OK: c_int = 0;
/// The input is sound but gives no frame to trust, or none that the dialect can tell: the error says why.
pub const TOUCHREF_REFUSED: c_int = 1;
/// The input or the call is wrong: the error says where.
pub const TOUCHREF_WRONG_INPUT: c_int = 2;
/// A fault in touchref or in a plugin; the library can be used on. Please report it.
pub const TOUCHREF_INTERNAL: c_int = 3;

/// Version of this interface: another number is another interface. See touchref_abi_version.
pub const TOUCHREF_ABI_VERSION: c_int = 1;

/// A position and orientation: of a frame, where it is in another one.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Pose {
    /// Origin.
    pub origin: [f64; 3],
    /// Quaternion x, y, z, w of any length above 0.
    pub quaternion_xyzw: [f64; 4],
}

/// A fixture's frame in the parent, in which the touches are told; the same rotation two ways.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Frame {
    /// The fixture's origin.
    pub origin: [f64; 3],
    /// Unit quaternion x, y, z, w of the rotation from fixture to parent; w is not negative.
    pub quaternion_xyzw: [f64; 4],
    /// Homogeneous matrix, matrix[row][column], that maps fixture coordinates into the parent.
    pub matrix: [[f64; 4]; 4],
}

/// Covariance of a frame: translation of the fixture's origin and rotation vector about it in radians, in the order
/// x, y, z, rx, ry, rz, all along the parent's axes.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Covariance {
    /// matrix[row][column]
    pub matrix: [[f64; 6]; 6],
    /// Standard deviation of one touch on which it rests.
    pub sigma: f64,
}

/// One frame that the equations allow, or that was weighed.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Root {
    /// The frame.
    pub frame: Frame,
    /// How far it is from the known geometry, in standard deviations; not a number where no sigma is stated.
    pub misfit: f64,
    /// 1 for the one that leads to the frame, 0 for the others.
    pub selected: c_int,
    /// Why it is, or why not; belongs to the solution.
    pub reason: *const c_char,
}

/// One probe contact. What is zero or NULL is not stated, so that only surface and at must be set in a touch that is
/// initialised to zeros.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Touch<'a> {
    /// Name of the surface; "?" where solver "robust" is to find it.
    pub surface: Text<'a>,
    /// Centre of the probe's tip in the parent. Not the contact point: the tip radius is part of the probe.
    pub at: [f64; 3],
    /// Standard deviation along the surface's normal; 0 for that of the probe.
    pub sigma: f64,
    /// Direction in which the probe moved, of any length; zeros where it is not known.
    pub approach: [f64; 3],
    /// What you call it; NULL for nothing.
    pub id: Text<'a>,
}

/// What is known of the probe.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Probe {
    /// Radius of the tip; 0 where touches are points of the surface.
    pub tip_radius: f64,
    /// Its standard uncertainty; 0 where it is exact.
    pub tip_radius_u: f64,
    /// Standard deviation of one touch along the normal; 0 where it is not stated.
    pub sigma: f64,
}

/// How to locate. NULL in its place, or zeros, are what the command line does by itself.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Options<'a> {
    /// Name of the solver; NULL for "least-squares".
    pub solver: Text<'a>,
    /// Its parameters as a JSON object or as TOML; NULL for none.
    pub solver_parameters: Text<'a>,
    /// Where the frame is expected: it decides between frames that fit equally well. NULL for anywhere.
    pub near_frame: Option<&'a Pose>,
}

/// Version of the library, as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn touchref_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => c"",
        };
    VERSION.as_ptr()
}

/// TOUCHREF_ABI_VERSION of the library that is linked: compare it with that of the header when the library is shared.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_abi_version() -> c_int {
    TOUCHREF_ABI_VERSION
}

/// Name of the kind of fixture with this index, in alphabetical order; NULL behind the last.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_fixture_kind(index: usize) -> *const c_char {
    at(&fixture::names().fixtures, index)
}

/// Name of the solver with this index, in alphabetical order; NULL behind the last.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solver_name(index: usize) -> *const c_char {
    at(&fixture::names().solvers, index)
}

/// Name of the dialect with this index, in alphabetical order; NULL behind the last.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_dialect_name(index: usize) -> *const c_char {
    at(&fixture::names().dialects, index)
}

/// Makes a fixture of this kind. `parameters` are a JSON object or TOML, as "radius = 15.0\nangle_deg = 45.0"; NULL for
/// none. `units` is the unit of every length, "mm", "m", "um" or "in".
///
/// Errors: unknown-fixture, unknown-key, missing-key, invalid-input.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_fixture_new(
    kind: Text<'_>,
    parameters: Text<'_>,
    units: Text<'_>,
    fixture: Option<&mut MaybeUninit<Option<Box<Fixture>>>>,
    error: Option<&mut MaybeUninit<Option<Box<Error>>>>,
) -> Status {
    guarded("fixture", fixture, error, || {
        let parameters = parameters.optional("parameters")?.unwrap_or_default();
        Ok(Fixture::new(kind.required("kind")?, parameters, units.required("units")?)?)
    })
}

/// How many surfaces the fixture has; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_fixture_surface_count(fixture: Option<&Fixture>) -> usize {
    fixture.map_or(0, |fixture| fixture.surfaces.len())
}

/// Name of the surface with this index; NULL behind the last. Belongs to the fixture.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_fixture_surface_name(fixture: Option<&Fixture>, index: usize) -> *const c_char {
    fixture.map_or(ptr::null(), |fixture| at(&fixture.surfaces, index))
}

/// Frees a fixture; nothing happens for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_fixture_free(fixture: Option<Box<Fixture>>) {
    drop(fixture);
}

/// Finds the frame of the fixture, or says why there is none to trust. `probe` must be given, `options` may be NULL.
///
/// Errors: ambiguous, degenerate, inconsistent, not-validated, not-converged (TOUCHREF_REFUSED); too-few-touches,
/// unknown-surface, unknown-solver, unknown-key, unsupported, invalid-input (TOUCHREF_WRONG_INPUT).
#[allow(clippy::missing_safety_doc)] // The header's beginning says what the caller promises of arrays.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn touchref_locate(
    fixture: Option<&Fixture>,
    touches: *const Touch<'_>,
    touch_count: usize,
    probe: Option<&Probe>,
    options: Option<&Options<'_>>,
    solution: Option<&mut MaybeUninit<Option<Box<Solution>>>>,
    error: Option<&mut MaybeUninit<Option<Box<Error>>>>,
) -> Status {
    guarded("solution", solution, error, || {
        let fixture = fixture.ok_or_else(|| null("fixture"))?;
        let probe = probe.ok_or_else(|| null("probe"))?;
        // SAFETY: the caller promises the same.
        let touches = unsafe { array(touches, touch_count, "touches") }?;
        locate(fixture.measurement(touches, probe)?, options)
    })
}

/// The same from the text of a measurement file, TOML or JSON: everything that the command line's `locate` takes, with
/// the same result. Tables and logs that it names are read from `folder`; NULL for the current one.
///
/// Errors: as of touchref_locate, and whatever is wrong with the text, with line, column and key.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_locate_measurement(
    text: Text<'_>,
    folder: Text<'_>,
    options: Option<&Options<'_>>,
    solution: Option<&mut MaybeUninit<Option<Box<Solution>>>>,
    error: Option<&mut MaybeUninit<Option<Box<Error>>>>,
) -> Status {
    guarded("solution", solution, error, || {
        let folder = folder.optional("folder")?.unwrap_or_default();
        locate(fixture::measurement_of(text.required("text")?, folder)?, options)
    })
}

/// The frame. TOUCHREF_WRONG_INPUT for NULL, and then nothing is written.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_frame(
    solution: Option<&Solution>,
    frame: Option<&mut MaybeUninit<Frame>>,
) -> Status {
    write(frame, solution.map(Solution::frame))
}

/// Its covariance. 1 where it is known; 0 where it is not, as no sigma is stated and no redundancy tells one, or for NULL:
/// then nothing is written.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_covariance(
    solution: Option<&Solution>,
    covariance: Option<&mut MaybeUninit<Covariance>>,
) -> c_int {
    c_int::from(write(covariance, solution.and_then(Solution::covariance)) == TOUCHREF_OK)
}

/// Root mean square of the residuals, a length. This and the other numbers are not a number (NaN) where they do not exist.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_rms(solution: Option<&Solution>) -> f64 {
    solution.map_or(f64::NAN, |solution| solution.solved.rms)
}

/// Squared misfit over the variance; NaN where no sigma is stated.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_chi_square(solution: Option<&Solution>) -> f64 {
    solution.and_then(|solution| solution.solved.chi_square).unwrap_or(f64::NAN)
}

/// Touches less unknowns; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_degrees_of_freedom(solution: Option<&Solution>) -> usize {
    solution.map_or(0, |solution| solution.solved.degrees_of_freedom)
}

/// Chance of a larger squared misfit; NaN where no sigma is stated, or no touch is left to check the others.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_p_value(solution: Option<&Solution>) -> f64 {
    solution.and_then(|solution| solution.solved.p_value).unwrap_or(f64::NAN)
}

/// How much better the touches see the best motion than the worst: ratio of singular values, 1 or more.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_condition(solution: Option<&Solution>) -> f64 {
    solution.map_or(f64::NAN, |solution| solution.solved.observability.condition)
}

/// The frame stands if the standard deviation of one touch is at least this, and at most touchref_solution_up_to_sigma.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_from_sigma(solution: Option<&Solution>) -> f64 {
    solution.map_or(f64::NAN, |solution| solution.solved.trust.from_sigma)
}

/// Above this the frame is not the only one, or its covariance not true; infinite where nothing limits it.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_up_to_sigma(solution: Option<&Solution>) -> f64 {
    solution.map_or(f64::NAN, |solution| solution.solved.trust.up_to_sigma)
}

/// How many touches the solution has, in the order in which they were given; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_touch_count(solution: Option<&Solution>) -> usize {
    solution.map_or(0, |solution| solution.solved.residuals.len())
}

/// Residual of the touch with this index: signed distance from its surface less the tip radius, a length. NaN behind the
/// last.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_residual(solution: Option<&Solution>, index: usize) -> f64 {
    let residual = solution.and_then(|solution| solution.solved.residuals.get(index));
    residual.map_or(f64::NAN, |residual| residual.length)
}

/// How many frames the equations allow, or were weighed; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_root_count(solution: Option<&Solution>) -> usize {
    solution.map_or(0, |solution| solution.solved.roots.len())
}

/// The root with this index. TOUCHREF_WRONG_INPUT behind the last, or for NULL, and then nothing is written.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_root(
    solution: Option<&Solution>,
    index: usize,
    root: Option<&mut MaybeUninit<Root>>,
) -> Status {
    write(root, solution.and_then(|solution| solution.root(index)))
}

/// How many warnings there are: what you should know although the frame stands; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_warning_count(solution: Option<&Solution>) -> usize {
    solution.map_or(0, |solution| solution.warning_codes.len())
}

/// Code of the warning with this index, for programs; NULL behind the last. Belongs to the solution.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_warning_code(solution: Option<&Solution>, index: usize) -> *const c_char {
    solution.map_or(ptr::null(), |solution| at(&solution.warning_codes, index))
}

/// The warning with this index in words; NULL behind the last. Belongs to the solution.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_warning_message(
    solution: Option<&Solution>,
    index: usize,
) -> *const c_char {
    solution.map_or(ptr::null(), |solution| at(&solution.warning_messages, index))
}

/// The whole result as JSON, touchref.solution/1: what `touchref locate --format json` prints. Belongs to the solution;
/// NULL for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_json(solution: Option<&Solution>) -> *const c_char {
    solution.map_or(ptr::null(), |solution| solution.json.as_ptr())
}

/// Frees a solution and all strings that belong to it; nothing happens for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_free(solution: Option<Box<Solution>>) {
    drop(solution);
}

/// The frame in the words of a machine, as "kuka", "fanuc:3" or "euler:zyx:intrinsic:deg"; read back before it is handed
/// out.
///
/// Errors: not-representable, dialect-failed (TOUCHREF_REFUSED); unknown-dialect, unknown-key, missing-key, invalid-input.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_solution_tell(
    solution: Option<&Solution>,
    dialect: Text<'_>,
    literal: Option<&mut MaybeUninit<Option<Box<Literal>>>>,
    error: Option<&mut MaybeUninit<Option<Box<Error>>>>,
) -> Status {
    guarded("literal", literal, error, || {
        solution.ok_or_else(|| null("solution"))?.tell(dialect.required("dialect")?)
    })
}

/// The text to paste, one line or several. Belongs to the literal; NULL for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_literal_text(literal: Option<&Literal>) -> *const c_char {
    literal.map_or(ptr::null(), |literal| literal.text.as_ptr())
}

/// What its numbers mean, where it goes, what to verify there and what rounding loses, as JSON: a member of
/// "dialect_notes" in touchref.solution/1. Belongs to the literal; NULL for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_literal_note_json(literal: Option<&Literal>) -> *const c_char {
    literal.map_or(ptr::null(), |literal| literal.note.as_ptr())
}

/// Frees a literal; nothing happens for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_literal_free(literal: Option<Box<Literal>>) {
    drop(literal);
}

/// The status of the call that gave this error; TOUCHREF_OK for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_error_status(error: Option<&Error>) -> Status {
    error.map_or(TOUCHREF_OK, |error| error.status)
}

/// By which programs know it: "ambiguous", "unknown-surface". Belongs to the error; NULL for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_error_code(error: Option<&Error>) -> *const c_char {
    error.map_or(ptr::null(), |error| error.code.as_ptr())
}

/// For people: what is wrong, with the measured value and the bound. Belongs to the error; NULL for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_error_message(error: Option<&Error>) -> *const c_char {
    error.map_or(ptr::null(), |error| error.message.as_ptr())
}

/// What to do about it; may be empty. Belongs to the error; NULL for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_error_help(error: Option<&Error>) -> *const c_char {
    error.map_or(ptr::null(), |error| error.help.as_ptr())
}

/// All that is known of it as JSON, touchref.error/1: the place in a text, the touches concerned, the frames that were
/// weighed. Belongs to the error; NULL for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_error_json(error: Option<&Error>) -> *const c_char {
    error.map_or(ptr::null(), |error| error.json.as_ptr())
}

/// Frees an error and all strings that belong to it; nothing happens for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_error_free(error: Option<Box<Error>>) {
    drop(error);
}

/// The string with this index, or null.
fn at(strings: &[CString], index: usize) -> *const c_char {
    strings.get(index).map_or(ptr::null(), |string| string.as_ptr())
}

/// Writes a value where there is one and a place for it.
fn write<T>(place: Option<&mut MaybeUninit<T>>, value: Option<T>) -> Status {
    match (place, value) {
        (Some(place), Some(value)) => {
            place.write(value);
            TOUCHREF_OK
        }
        _ => TOUCHREF_WRONG_INPUT,
    }
}
