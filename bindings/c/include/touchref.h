/**
 * touchref: from probe touches on a reference fixture to its 6-DoF frame, how far that can be trusted, or a refusal.
 *
 * Made by cbindgen from bindings/c/src: change it there.
 *
 * Results: a function that can fail returns a touchref_status, sets its result where that is TOUCHREF_OK and its error where
 * it is not, and sets the other one to NULL. Result and error may hold anything before. An error that nobody wants may be
 * given as NULL.
 *
 * Ownership: what a function of the name touchref_..._new, touchref_locate..., or touchref_solution_tell hands out belongs to
 * the caller, who frees it once by the function of its type: touchref_fixture_free, touchref_solution_free,
 * touchref_literal_free, touchref_error_free. A `const char *` that is returned belongs to the object that it was asked of,
 * lasts as long, and is not freed; names of plugins and the version last forever. What is handed in stays the caller's and is
 * not kept: a fixture may be freed before the solutions that were located with it.
 *
 * Threads: every function may be called from any thread at any time. Objects never change once they are made, so that any
 * number of threads may use one at the same time; freeing it is for one thread, after all others are done with it. There
 * is no other state.
 *
 * Wrong calls: NULL, text that is not UTF-8, numbers that are not finite and indices behind the end are errors with status
 * TOUCHREF_WRONG_INPUT, or are answered as each function says. What cannot be checked is the caller's promise: strings end
 * with a zero byte, arrays are as long as their count, handles are live and of their type. A fault of the library is an
 * error with status TOUCHREF_INTERNAL; nothing is thrown, and nothing ends the program.
 *
 * Units: lengths in the unit that the fixture or the measurement states, angles in radians.
 */
#ifndef TOUCHREF_H
#define TOUCHREF_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/**
 * It is done; of touchref_locate: a frame that passed its checks.
 */
#define TOUCHREF_OK 0

/**
 * The input is sound but gives no frame to trust, or none that the dialect can tell: the error says why.
 */
#define TOUCHREF_REFUSED 1

/**
 * The input or the call is wrong: the error says where.
 */
#define TOUCHREF_WRONG_INPUT 2

/**
 * A fault in touchref or in a plugin; the library can be used on. Please report it.
 */
#define TOUCHREF_INTERNAL 3

/**
 * Version of this interface: another number is another interface. See touchref_abi_version.
 */
#define TOUCHREF_ABI_VERSION 1

/**
 * Why a call gives no result.
 */
typedef struct touchref_error touchref_error;

/**
 * A kind of fixture with its parameters.
 */
typedef struct touchref_fixture touchref_fixture;

/**
 * A frame in the words of a machine.
 */
typedef struct touchref_literal touchref_literal;

/**
 * A frame with all that was weighed on the way.
 */
typedef struct touchref_solution touchref_solution;

/**
 * What came of a call: one of the numbers above. 0 to 2 are the exit statuses of the command line.
 */
typedef int touchref_status;

/**
 * One probe contact. What is zero or NULL is not stated, so that only surface and at must be set in a touch that is
 * initialised to zeros.
 */
typedef struct {
    /**
     * Name of the surface; "?" where solver "robust" is to find it.
     */
    const char *surface;
    /**
     * Centre of the probe's tip in the parent. Not the contact point: the tip radius is part of the probe.
     */
    double at[3];
    /**
     * Standard deviation along the surface's normal; 0 for that of the probe.
     */
    double sigma;
    /**
     * Direction in which the probe moved, of any length; zeros where it is not known.
     */
    double approach[3];
    /**
     * What you call it; NULL for nothing.
     */
    const char *id;
} touchref_touch;

/**
 * What is known of the probe.
 */
typedef struct {
    /**
     * Radius of the tip; 0 where touches are points of the surface.
     */
    double tip_radius;
    /**
     * Its standard uncertainty; 0 where it is exact.
     */
    double tip_radius_u;
    /**
     * Standard deviation of one touch along the normal; 0 where it is not stated.
     */
    double sigma;
} touchref_probe;

/**
 * A position and orientation: of a frame, where it is in another one.
 */
typedef struct {
    /**
     * Origin.
     */
    double origin[3];
    /**
     * Quaternion x, y, z, w of any length above 0.
     */
    double quaternion_xyzw[4];
} touchref_pose;

/**
 * How to locate. NULL in its place, or zeros, are what the command line does by itself.
 */
typedef struct {
    /**
     * Name of the solver; NULL for "least-squares".
     */
    const char *solver;
    /**
     * Its parameters as a JSON object or as TOML; NULL for none.
     */
    const char *solver_parameters;
    /**
     * Where the frame is expected: it decides between frames that fit equally well. NULL for anywhere.
     */
    const touchref_pose *near_frame;
} touchref_options;

/**
 * A fixture's frame in the parent, in which the touches are told; the same rotation two ways.
 */
typedef struct {
    /**
     * The fixture's origin.
     */
    double origin[3];
    /**
     * Unit quaternion x, y, z, w of the rotation from fixture to parent; w is not negative.
     */
    double quaternion_xyzw[4];
    /**
     * Homogeneous matrix, matrix[row][column], that maps fixture coordinates into the parent.
     */
    double matrix[4][4];
} touchref_frame;

/**
 * Covariance of a frame: translation of the fixture's origin and rotation vector about it in radians, in the order
 * x, y, z, rx, ry, rz, all along the parent's axes.
 */
typedef struct {
    /**
     * matrix[row][column]
     */
    double matrix[6][6];
    /**
     * Standard deviation of one touch on which it rests.
     */
    double sigma;
} touchref_covariance;

/**
 * One frame that the equations allow, or that was weighed.
 */
typedef struct {
    /**
     * The frame.
     */
    touchref_frame frame;
    /**
     * How far it is from the known geometry, in standard deviations; not a number where no sigma is stated.
     */
    double misfit;
    /**
     * 1 for the one that leads to the frame, 0 for the others.
     */
    int selected;
    /**
     * Why it is, or why not; belongs to the solution.
     */
    const char *reason;
} touchref_root;

/**
 * Version of the library, as "0.1.0".
 */
const char *touchref_version(void);

/**
 * TOUCHREF_ABI_VERSION of the library that is linked: compare it with that of the header when the library is shared.
 */
int touchref_abi_version(void);

/**
 * Name of the kind of fixture with this index, in alphabetical order; NULL behind the last.
 */
const char *touchref_fixture_kind(size_t index);

/**
 * Name of the solver with this index, in alphabetical order; NULL behind the last.
 */
const char *touchref_solver_name(size_t index);

/**
 * Name of the dialect with this index, in alphabetical order; NULL behind the last.
 */
const char *touchref_dialect_name(size_t index);

/**
 * Makes a fixture of this kind. `parameters` are a JSON object or TOML, as "radius = 15.0\nangle_deg = 45.0"; NULL for
 * none. `units` is the unit of every length, "mm", "m", "um" or "in".
 *
 * Errors: unknown-fixture, unknown-key, missing-key, invalid-input.
 */
touchref_status touchref_fixture_new(const char *kind,
                                     const char *parameters,
                                     const char *units,
                                     touchref_fixture **fixture,
                                     touchref_error **error);

/**
 * How many surfaces the fixture has; 0 for NULL.
 */
size_t touchref_fixture_surface_count(const touchref_fixture *fixture);

/**
 * Name of the surface with this index; NULL behind the last. Belongs to the fixture.
 */
const char *touchref_fixture_surface_name(const touchref_fixture *fixture, size_t index);

/**
 * Frees a fixture; nothing happens for NULL.
 */
void touchref_fixture_free(touchref_fixture *fixture);

/**
 * Finds the frame of the fixture, or says why there is none to trust. `probe` must be given, `options` may be NULL.
 *
 * Errors: ambiguous, degenerate, inconsistent, not-validated, not-converged (TOUCHREF_REFUSED); too-few-touches,
 * unknown-surface, unknown-solver, unknown-key, unsupported, invalid-input (TOUCHREF_WRONG_INPUT).
 */
touchref_status touchref_locate(const touchref_fixture *fixture,
                                const touchref_touch *touches,
                                size_t touch_count,
                                const touchref_probe *probe,
                                const touchref_options *options,
                                touchref_solution **solution,
                                touchref_error **error);

/**
 * The same from the text of a measurement file, TOML or JSON: everything that the command line's `locate` takes, with
 * the same result. Tables and logs that it names are read from `folder`; NULL for the current one.
 *
 * Errors: as of touchref_locate, and whatever is wrong with the text, with line, column and key.
 */
touchref_status touchref_locate_measurement(const char *text,
                                            const char *folder,
                                            const touchref_options *options,
                                            touchref_solution **solution,
                                            touchref_error **error);

/**
 * The frame. TOUCHREF_WRONG_INPUT for NULL, and then nothing is written.
 */
touchref_status touchref_solution_frame(const touchref_solution *solution, touchref_frame *frame);

/**
 * Its covariance. 1 where it is known; 0 where it is not, as no sigma is stated and no redundancy tells one, or for NULL:
 * then nothing is written.
 */
int touchref_solution_covariance(const touchref_solution *solution,
                                 touchref_covariance *covariance);

/**
 * Root mean square of the residuals, a length. This and the other numbers are not a number (NaN) where they do not exist.
 */
double touchref_solution_rms(const touchref_solution *solution);

/**
 * Squared misfit over the variance; NaN where no sigma is stated.
 */
double touchref_solution_chi_square(const touchref_solution *solution);

/**
 * Touches less unknowns; 0 for NULL.
 */
size_t touchref_solution_degrees_of_freedom(const touchref_solution *solution);

/**
 * Chance of a larger squared misfit; NaN where no sigma is stated, or no touch is left to check the others.
 */
double touchref_solution_p_value(const touchref_solution *solution);

/**
 * How much better the touches see the best motion than the worst: ratio of singular values, 1 or more.
 */
double touchref_solution_condition(const touchref_solution *solution);

/**
 * The frame stands if the standard deviation of one touch is at least this, and at most touchref_solution_up_to_sigma.
 */
double touchref_solution_from_sigma(const touchref_solution *solution);

/**
 * Above this the frame is not the only one, or its covariance not true; infinite where nothing limits it.
 */
double touchref_solution_up_to_sigma(const touchref_solution *solution);

/**
 * How many touches the solution has, in the order in which they were given; 0 for NULL.
 */
size_t touchref_solution_touch_count(const touchref_solution *solution);

/**
 * Residual of the touch with this index: signed distance from its surface less the tip radius, a length. NaN behind the
 * last.
 */
double touchref_solution_residual(const touchref_solution *solution,
                                  size_t index);

/**
 * How many frames the equations allow, or were weighed; 0 for NULL.
 */
size_t touchref_solution_root_count(const touchref_solution *solution);

/**
 * The root with this index. TOUCHREF_WRONG_INPUT behind the last, or for NULL, and then nothing is written.
 */
touchref_status touchref_solution_root(const touchref_solution *solution,
                                       size_t index,
                                       touchref_root *root);

/**
 * How many warnings there are: what you should know although the frame stands; 0 for NULL.
 */
size_t touchref_solution_warning_count(const touchref_solution *solution);

/**
 * Code of the warning with this index, for programs; NULL behind the last. Belongs to the solution.
 */
const char *touchref_solution_warning_code(const touchref_solution *solution, size_t index);

/**
 * The warning with this index in words; NULL behind the last. Belongs to the solution.
 */
const char *touchref_solution_warning_message(const touchref_solution *solution, size_t index);

/**
 * The whole result as JSON, touchref.solution/1: what `touchref locate --format json` prints. Belongs to the solution;
 * NULL for NULL.
 */
const char *touchref_solution_json(const touchref_solution *solution);

/**
 * Frees a solution and all strings that belong to it; nothing happens for NULL.
 */
void touchref_solution_free(touchref_solution *solution);

/**
 * The frame in the words of a machine, as "kuka", "fanuc:3" or "euler:zyx:intrinsic:deg"; read back before it is handed
 * out.
 *
 * Errors: not-representable, dialect-failed (TOUCHREF_REFUSED); unknown-dialect, unknown-key, missing-key, invalid-input.
 */
touchref_status touchref_solution_tell(const touchref_solution *solution,
                                       const char *dialect,
                                       touchref_literal **literal,
                                       touchref_error **error);

/**
 * The text to paste, one line or several. Belongs to the literal; NULL for NULL.
 */
const char *touchref_literal_text(const touchref_literal *literal);

/**
 * What its numbers mean, where it goes, what to verify there and what rounding loses, as JSON: a member of
 * "dialect_notes" in touchref.solution/1. Belongs to the literal; NULL for NULL.
 */
const char *touchref_literal_note_json(const touchref_literal *literal);

/**
 * Frees a literal; nothing happens for NULL.
 */
void touchref_literal_free(touchref_literal *literal);

/**
 * The status of the call that gave this error; TOUCHREF_OK for NULL.
 */
touchref_status touchref_error_status(const touchref_error *error);

/**
 * By which programs know it: "ambiguous", "unknown-surface". Belongs to the error; NULL for NULL.
 */
const char *touchref_error_code(const touchref_error *error);

/**
 * For people: what is wrong, with the measured value and the bound. Belongs to the error; NULL for NULL.
 */
const char *touchref_error_message(const touchref_error *error);

/**
 * What to do about it; may be empty. Belongs to the error; NULL for NULL.
 */
const char *touchref_error_help(const touchref_error *error);

/**
 * All that is known of it as JSON, touchref.error/1: the place in a text, the touches concerned, the frames that were
 * weighed. Belongs to the error; NULL for NULL.
 */
const char *touchref_error_json(const touchref_error *error);

/**
 * Frees an error and all strings that belong to it; nothing happens for NULL.
 */
void touchref_error_free(touchref_error *error);

#ifdef __cplusplus
}
#endif

#endif
