/*
 * What bindings/c/check runs, plainly, under valgrind and with sanitizers:
 *
 *   calls plugins                    prints the name of every plugin
 *   calls locate FILE FOLDER [SOLVER]    prints the result or the error of a measurement file as JSON, and exits with its status
 *   calls all FILE                   makes every call rightly and wrongly; FILE is the paper's measurement
 */

#include <float.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <touchref.h>

static int failures = 0;

#define CHECK(condition)                                                                                     \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                          \
            failures++;                                                                                      \
        }                                                                                                    \
    } while (0)

static int same(const char *a, const char *b)
{
    return a != NULL && b != NULL && strcmp(a, b) == 0;
}

/* Whether a text says these words. */
static int tells(const char *text, const char *words)
{
    return text != NULL && strstr(text, words) != NULL;
}

static char *read_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    char *text = calloc(1, 1 << 20);
    if (file == NULL || text == NULL) {
        perror(path);
        exit(9);
    }
    if (fread(text, 1, (1 << 20) - 1, file) == 0) {
        exit(9);
    }
    fclose(file);
    return text;
}

static void print_names(const char *what, const char *(*name)(size_t))
{
    size_t i;
    for (i = 0; name(i) != NULL; i++) {
        printf("%s %s\n", what, name(i));
    }
}

static int locate_file(const char *path, const char *folder, const char *solver)
{
    char *text = read_file(path);
    touchref_options options = {NULL, NULL, NULL};
    touchref_solution *solution;
    touchref_error *error;
    touchref_status status;

    options.solver = solver;
    status = touchref_locate_measurement(text, folder, &options, &solution, &error);
    free(text);
    CHECK((solution != NULL) == (status == TOUCHREF_OK) && (error == NULL) == (status == TOUCHREF_OK));
    fputs(status == TOUCHREF_OK ? touchref_solution_json(solution) : touchref_error_json(error), stdout);
    CHECK(touchref_error_status(error) == status);
    touchref_solution_free(solution);
    touchref_error_free(error);
    return failures == 0 ? status : 9;
}

static const char *const SURFACES[7] = {"cylinder", "cylinder", "cylinder", "cylinder", "plane", "plane", "plane"};
static const char *const IDS[7] = {"x1", "x2", "x3", "x4", "x5", "x6", "x7"};
static const double AT[7][3] = {{2.9270, 2.0000, 1.6250}, {1.7750, 2.8000, 1.4438}, {1.3730, 2.6000, 3.1166},
                                {3.5270, 3.2000, 3.1082}, {2.8250, 2.4000, 4.0395}, {3.9020, 5.2000, 4.0353},
                                {2.0480, 5.2000, 4.7853}};
static const touchref_probe PROBE = {0.0, 0.0, 0.00005};

static void paper(touchref_touch touches[7])
{
    size_t i;
    memset(touches, 0, 7 * sizeof touches[0]);
    for (i = 0; i < 7; i++) {
        touches[i].surface = SURFACES[i];
        touches[i].id = IDS[i];
        memcpy(touches[i].at, AT[i], sizeof AT[i]);
    }
}

static touchref_fixture *paper_fixture(void)
{
    touchref_fixture *fixture;
    touchref_error *error = (touchref_error *)8; /* what was there is not read */
    CHECK(touchref_fixture_new("cylinder-plane", "{\"radius\": 1.0, \"angle_deg\": 45.0}", "mm", &fixture, &error) ==
          TOUCHREF_OK);
    CHECK(error == NULL);
    return fixture;
}

/* A call that must fail so: status, code, and what the message says. */
static void refused(touchref_status status, touchref_error *error, touchref_status expected, const char *code,
                    const char *words)
{
    const char *message = touchref_error_message(error);
    if (status != expected || !same(touchref_error_code(error), code) || !tells(message, words)) {
        fprintf(stderr, "expected %d, %s, ..%s..; got %d, %s, %s\n", expected, code, words, status,
                touchref_error_code(error), message);
        failures++;
    }
    CHECK(touchref_error_status(error) == expected);
    CHECK(tells(touchref_error_json(error), "touchref.error/1"));
    CHECK(touchref_error_help(error) != NULL);
    touchref_error_free(error);
}

static void right_calls(const char *text)
{
    touchref_fixture *fixture = paper_fixture();
    touchref_touch touches[7];
    touchref_solution *solution, *from_text;
    touchref_error *error;
    touchref_frame frame;
    touchref_covariance covariance;
    touchref_root root;
    touchref_literal *literal;
    touchref_options options = {NULL, NULL, NULL};
    touchref_pose near = {{2.9, 3.8, 4.2}, {0.0, 0.0, 0.0, 2.0}};
    size_t i, selected = 0;
    double squares = 0.0;

    CHECK(same(touchref_version(), VERSION));
    CHECK(touchref_abi_version() == TOUCHREF_ABI_VERSION);
    CHECK(touchref_fixture_surface_count(fixture) == 2);
    CHECK(same(touchref_fixture_surface_name(fixture, 0), "cylinder"));
    CHECK(same(touchref_fixture_surface_name(fixture, 1), "plane"));
    CHECK(touchref_fixture_surface_name(fixture, 2) == NULL);

    paper(touches);
    CHECK(touchref_locate(fixture, touches, 7, &PROBE, NULL, &solution, &error) == TOUCHREF_OK && error == NULL);
    touchref_fixture_free(fixture); /* the solution does not need it */

    /* The answer that the paper prints, to its digits and the rounding of its touches. */
    CHECK(touchref_solution_frame(solution, &frame) == TOUCHREF_OK);
    CHECK(fabs(frame.origin[0] - 2.9) < 2e-4 && fabs(frame.origin[1] - 3.8) < 2e-4 &&
          fabs(frame.origin[2] - 4.2249) < 2e-4);
    CHECK(fabs(frame.matrix[0][2] - 0.3) < 2e-4 && fabs(frame.matrix[1][2] - 0.6) < 2e-4 &&
          fabs(frame.matrix[2][2] - 0.7416) < 2e-4);
    CHECK(frame.matrix[0][3] == frame.origin[0] && frame.matrix[3][3] == 1.0 && frame.matrix[3][0] == 0.0);
    for (i = 0; i < 4; i++) {
        squares += frame.quaternion_xyzw[i] * frame.quaternion_xyzw[i];
    }
    CHECK(fabs(squares - 1.0) < 1e-12 && frame.quaternion_xyzw[3] >= 0.0);
    /* Column 0 of a rotation from its quaternion x, y, z, w. */
    CHECK(fabs(frame.matrix[1][0] - 2.0 * (frame.quaternion_xyzw[0] * frame.quaternion_xyzw[1] +
                                           frame.quaternion_xyzw[2] * frame.quaternion_xyzw[3])) < 1e-12);

    CHECK(touchref_solution_covariance(solution, &covariance) == 1);
    CHECK(covariance.sigma == 0.00005);
    for (i = 0; i < 36; i++) {
        /* Symmetric, but for rounding. */
        CHECK(fabs(covariance.matrix[i / 6][i % 6] - covariance.matrix[i % 6][i / 6]) < 1e-12 * covariance.matrix[0][0]);
    }
    CHECK(covariance.matrix[0][0] > 0.0 && sqrt(covariance.matrix[0][0]) < 1e-3);
    CHECK(touchref_solution_rms(solution) < 5e-5);
    CHECK(touchref_solution_degrees_of_freedom(solution) == 1);
    CHECK(touchref_solution_chi_square(solution) < 4.0);
    CHECK(touchref_solution_p_value(solution) > 0.05 && touchref_solution_p_value(solution) < 1.0);
    CHECK(touchref_solution_condition(solution) > 1.0);
    CHECK(touchref_solution_from_sigma(solution) < 0.00005 && touchref_solution_up_to_sigma(solution) > 0.00005);
    CHECK(touchref_solution_touch_count(solution) == 7);
    CHECK(fabs(touchref_solution_residual(solution, 0)) < 1e-4 && isnan(touchref_solution_residual(solution, 7)));
    CHECK(touchref_solution_warning_count(solution) == 1 && touchref_solution_warning_code(solution, 0) != NULL);
    CHECK(tells(touchref_solution_warning_message(solution, 0), "7 touches"));
    CHECK(touchref_solution_warning_code(solution, 1) == NULL && touchref_solution_warning_message(solution, 1) == NULL);
    CHECK(touchref_solution_root_count(solution) == 4);
    for (i = 0; touchref_solution_root(solution, i, &root) == TOUCHREF_OK; i++) {
        selected += root.selected != 0;
        CHECK(root.reason != NULL && root.misfit >= 0.0);
    }
    CHECK(i == 4 && selected == 1);

    CHECK(touchref_solution_tell(solution, "kuka", &literal, &error) == TOUCHREF_OK && error == NULL);
    CHECK(tells(touchref_literal_text(literal), "X 2.9"));
    CHECK(tells(touchref_literal_note_json(literal), "rounding_loss"));
    touchref_literal_free(literal);

    /* Touches in memory and touches in a text are the same measurement. */
    CHECK(touchref_locate_measurement(text, NULL, NULL, &from_text, NULL) == TOUCHREF_OK);
    CHECK(same(touchref_solution_json(solution), touchref_solution_json(from_text)));
    touchref_solution_free(from_text);
    touchref_solution_free(solution);

    /* Options, a touch's own sigma and approach, no sigma at all, warnings, a fixture that others use. */
    fixture = paper_fixture();
    options.solver = "closed-form";
    options.solver_parameters = "";
    options.near_frame = &near;
    for (i = 0; i < 7; i++) {
        touches[i].sigma = 0.0001;
        touches[i].approach[2] = i < 4 ? 0.0 : -3.0;
        touches[i].id = NULL;
    }
    CHECK(touchref_locate(fixture, touches, 7, &PROBE, &options, &solution, NULL) == TOUCHREF_OK);
    CHECK(tells(touchref_solution_json(solution), "\"solver\": \"closed-form\""));
    CHECK(tells(touchref_solution_json(solution), "\"sigma\": 0.0001"));
    touchref_solution_free(solution);
    {
        touchref_probe unknown = {0.0, 0.0, 0.0};
        paper(touches);
        CHECK(touchref_locate(fixture, touches, 7, &unknown, NULL, &solution, NULL) == TOUCHREF_OK);
        CHECK(isnan(touchref_solution_chi_square(solution)));
        touchref_solution_free(solution);
    }
    touchref_fixture_free(fixture);
}

static void wrong_calls(void)
{
    touchref_fixture *fixture = paper_fixture(), *none;
    touchref_touch touches[7];
    touchref_solution *solution = NULL, *found;
    touchref_literal *literal;
    touchref_error *error;
    touchref_options options = {NULL, NULL, NULL};
    touchref_probe probe;
    touchref_frame frame;
    touchref_covariance covariance;
    touchref_root root;
    touchref_pose near = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0}};
    const double not_numbers[3] = {NAN, INFINITY, -INFINITY};
    touchref_status status;
    size_t i;

#define FIXTURE(kind, parameters, units, code, words)                                                        \
    status = touchref_fixture_new(kind, parameters, units, &none, &error);                                   \
    CHECK(none == NULL);                                                                                     \
    refused(status, error, TOUCHREF_WRONG_INPUT, code, words)
#define LOCATE(fixture, touches, count, probe, options, expected, code, words)                               \
    status = touchref_locate(fixture, touches, count, probe, options, &solution, &error);                    \
    CHECK(solution == NULL);                                                                                 \
    refused(status, error, expected, code, words)

    FIXTURE("cylinder-plan", NULL, "mm", "unknown-fixture", "cylinder-plane");
    FIXTURE(NULL, NULL, "mm", "invalid-input", "kind is NULL");
    FIXTURE("cube", NULL, NULL, "invalid-input", "units is NULL");
    FIXTURE("cube", "edge = 80", "furlong", "unknown-name", "mm");
    FIXTURE("cube", "edgy = 80", "mm", "unknown-key", "edge");
    FIXTURE("cylinder-plane", NULL, "mm", "missing-key", "radius");
    FIXTURE("cylinder-plane", "radius = -1\nangle_deg = 45", "mm", "invalid-input", "radius");
    FIXTURE("cylinder-plane", "{\"radius\": 1.0,", "mm", "invalid-input", "JSON");
    FIXTURE("cube", "\xff\xfe", "mm", "invalid-input", "UTF-8");
    FIXTURE("\x80", NULL, "mm", "invalid-input", "UTF-8");
    CHECK(touchref_fixture_new("cube", "edge = 80", "mm", NULL, &error) == TOUCHREF_WRONG_INPUT);
    CHECK(same(touchref_error_message(error), "fixture is NULL"));
    touchref_error_free(error);
    CHECK(touchref_fixture_new("no", NULL, NULL, NULL, NULL) == TOUCHREF_WRONG_INPUT);

    paper(touches);
    LOCATE(NULL, touches, 7, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "fixture is NULL");
    LOCATE(fixture, NULL, 7, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "touches is NULL");
    LOCATE(fixture, touches, (size_t)-1, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "elements");
    LOCATE(fixture, touches, 7, NULL, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "probe is NULL");
    LOCATE(fixture, NULL, 0, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "too-few-touches", "no touches");
    LOCATE(fixture, touches, 6, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "too-few-touches", "plane");
    LOCATE(fixture, (const touchref_touch *)((const char *)touches + 1), 6, &PROBE, NULL, TOUCHREF_WRONG_INPUT,
           "invalid-input", "aligned");
    CHECK(touchref_locate(fixture, touches, 7, &PROBE, NULL, NULL, &error) == TOUCHREF_WRONG_INPUT);
    CHECK(same(touchref_error_message(error), "solution is NULL"));
    touchref_error_free(error);
    touches[5].surface = "plain";
    LOCATE(fixture, touches, 7, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "unknown-surface", "plain");
    touches[5].surface = NULL;
    LOCATE(fixture, touches, 7, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "touch[5].surface is NULL");
    touches[5].surface = "pl\xffne";
    LOCATE(fixture, touches, 7, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "from byte 2");
    touches[5].surface = "?";
    LOCATE(fixture, touches, 7, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "unknown-surface", "5");
    paper(touches);
    touches[2].id = "\xc3";
    LOCATE(fixture, touches, 7, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "touch[2].id");
    for (i = 0; i < 3; i++) {
        paper(touches);
        touches[6].at[1] = not_numbers[i];
        LOCATE(fixture, touches, 7, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "touch 6: a coordinate");
        paper(touches);
        touches[6].approach[1] = not_numbers[i];
        LOCATE(fixture, touches, 7, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "touch 6: a component");
        paper(touches);
        touches[6].sigma = not_numbers[i];
        LOCATE(fixture, touches, 7, &PROBE, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "touch 6: sigma");
        paper(touches);
        probe = PROBE;
        probe.tip_radius = not_numbers[i];
        LOCATE(fixture, touches, 7, &probe, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "tip radius");
        probe = PROBE;
        probe.tip_radius_u = not_numbers[i];
        LOCATE(fixture, touches, 7, &probe, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "tip radius");
        probe = PROBE;
        probe.sigma = not_numbers[i];
        LOCATE(fixture, touches, 7, &probe, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "sigma");
    }
    /* Numbers that overflow on the way are refused, whatever the words. */
    touches[6].at[1] = DBL_MAX;
    CHECK(touchref_locate(fixture, touches, 7, &PROBE, NULL, &solution, NULL) != TOUCHREF_OK && solution == NULL);
    paper(touches);
    touches[0].sigma = 1e-5;
    probe = PROBE;
    probe.sigma = 0.0;
    LOCATE(fixture, touches, 7, &probe, NULL, TOUCHREF_WRONG_INPUT, "invalid-input", "sigma");
    paper(touches);

    options.solver = "least-square";
    LOCATE(fixture, touches, 7, &PROBE, &options, TOUCHREF_WRONG_INPUT, "unknown-solver", "least-squares");
    options.solver = "\xf5";
    LOCATE(fixture, touches, 7, &PROBE, &options, TOUCHREF_WRONG_INPUT, "invalid-input", "options.solver");
    options.solver = NULL;
    options.solver_parameters = "{\"no\": 1}";
    LOCATE(fixture, touches, 7, &PROBE, &options, TOUCHREF_WRONG_INPUT, "unknown-key", "least-squares");
    options.solver_parameters = NULL;
    options.near_frame = &near;
    LOCATE(fixture, touches, 7, &PROBE, &options, TOUCHREF_WRONG_INPUT, "invalid-input", "no rotation");

    /* Refusals: sound input without a frame to trust. */
    probe = PROBE;
    probe.sigma = 0.1;
    LOCATE(fixture, touches, 7, &probe, NULL, TOUCHREF_REFUSED, "ambiguous", "");
    touches[0].at[0] += 0.01;
    LOCATE(fixture, touches, 7, &PROBE, NULL, TOUCHREF_REFUSED, "inconsistent", "");

    status = touchref_locate_measurement("units = \"mm\"\nfixtur = 1\n", NULL, NULL, &solution, &error);
    CHECK(solution == NULL && tells(touchref_error_json(error), "\"line\": 2"));
    refused(status, error, TOUCHREF_WRONG_INPUT, "unknown-key", "fixtur");
    status = touchref_locate_measurement(NULL, NULL, NULL, &solution, &error);
    refused(status, error, TOUCHREF_WRONG_INPUT, "invalid-input", "text is NULL");
    status = touchref_locate_measurement("\xff", NULL, NULL, &solution, &error);
    refused(status, error, TOUCHREF_WRONG_INPUT, "invalid-input", "UTF-8");
    status = touchref_locate_measurement("", NULL, NULL, &solution, &error);
    refused(status, error, TOUCHREF_WRONG_INPUT, "missing-key", "units");
    status = touchref_locate_measurement("units = \"mm\"\ntouches = \"no-such.csv\"\n[fixture]\nkind = \"cube\"\nedge = 80\n",
                                         "/nowhere", NULL, &solution, &error);
    refused(status, error, TOUCHREF_WRONG_INPUT, "unreadable", "/nowhere/no-such.csv");

    paper(touches);
    CHECK(touchref_locate(fixture, touches, 7, &PROBE, NULL, &found, NULL) == TOUCHREF_OK);
    status = touchref_solution_tell(found, "kuca", &literal, &error);
    CHECK(literal == NULL);
    refused(status, error, TOUCHREF_WRONG_INPUT, "unknown-dialect", "kuka");
    status = touchref_solution_tell(found, NULL, &literal, &error);
    refused(status, error, TOUCHREF_WRONG_INPUT, "invalid-input", "dialect is NULL");
    status = touchref_solution_tell(NULL, "kuka", &literal, &error);
    refused(status, error, TOUCHREF_WRONG_INPUT, "invalid-input", "solution is NULL");
    status = touchref_solution_tell(found, "linuxcnc", &literal, &error); /* it cannot tell a tilt */
    refused(status, error, TOUCHREF_REFUSED, "not-representable", "tilt");
    CHECK(touchref_solution_root(found, 4, &root) == TOUCHREF_WRONG_INPUT);
    CHECK(touchref_solution_root(found, 0, NULL) == TOUCHREF_WRONG_INPUT);
    CHECK(touchref_solution_frame(found, NULL) == TOUCHREF_WRONG_INPUT);
    CHECK(touchref_solution_covariance(found, NULL) == 0);
    touchref_solution_free(found);
    touchref_fixture_free(fixture);

    /* Every function takes NULL. */
    CHECK(touchref_fixture_surface_count(NULL) == 0 && touchref_fixture_surface_name(NULL, 0) == NULL);
    CHECK(touchref_solution_frame(NULL, &frame) == TOUCHREF_WRONG_INPUT);
    CHECK(touchref_solution_covariance(NULL, &covariance) == 0);
    CHECK(isnan(touchref_solution_rms(NULL)) && isnan(touchref_solution_chi_square(NULL)));
    CHECK(isnan(touchref_solution_p_value(NULL)) && isnan(touchref_solution_condition(NULL)));
    CHECK(isnan(touchref_solution_from_sigma(NULL)) && isnan(touchref_solution_up_to_sigma(NULL)));
    CHECK(isnan(touchref_solution_residual(NULL, 0)) && touchref_solution_degrees_of_freedom(NULL) == 0);
    CHECK(touchref_solution_touch_count(NULL) == 0 && touchref_solution_root_count(NULL) == 0);
    CHECK(touchref_solution_root(NULL, 0, &root) == TOUCHREF_WRONG_INPUT);
    CHECK(touchref_solution_warning_count(NULL) == 0 && touchref_solution_warning_code(NULL, 0) == NULL);
    CHECK(touchref_solution_warning_message(NULL, 0) == NULL && touchref_solution_json(NULL) == NULL);
    CHECK(touchref_literal_text(NULL) == NULL && touchref_literal_note_json(NULL) == NULL);
    CHECK(touchref_error_status(NULL) == TOUCHREF_OK && touchref_error_code(NULL) == NULL);
    CHECK(touchref_error_message(NULL) == NULL && touchref_error_help(NULL) == NULL);
    CHECK(touchref_error_json(NULL) == NULL);
    touchref_fixture_free(NULL);
    touchref_solution_free(NULL);
    touchref_literal_free(NULL);
    touchref_error_free(NULL);
}

/* What threads share: a fixture, and a solution to compare with. */
typedef struct {
    const touchref_fixture *fixture;
    const touchref_solution *solution;
    int same;
} work;

static void *locate_again(void *given)
{
    work *mine = given;
    touchref_touch touches[7];
    touchref_solution *solution;

    paper(touches);
    if (touchref_locate(mine->fixture, touches, 7, &PROBE, NULL, &solution, NULL) == TOUCHREF_OK) {
        mine->same = same(touchref_solution_json(solution), touchref_solution_json(mine->solution));
        touchref_solution_free(solution);
    }
    return NULL;
}

static void threads(void)
{
    enum { THREADS = 4 };
    touchref_fixture *fixture = paper_fixture();
    touchref_touch touches[7];
    touchref_solution *solution;
    pthread_t thread[THREADS];
    work shared[THREADS];
    int i;

    paper(touches);
    CHECK(touchref_locate(fixture, touches, 7, &PROBE, NULL, &solution, NULL) == TOUCHREF_OK);
    for (i = 0; i < THREADS; i++) {
        shared[i].fixture = fixture;
        shared[i].solution = solution;
        shared[i].same = 0;
        CHECK(pthread_create(&thread[i], NULL, locate_again, &shared[i]) == 0);
    }
    for (i = 0; i < THREADS; i++) {
        CHECK(pthread_join(thread[i], NULL) == 0);
        CHECK(shared[i].same);
    }
    touchref_solution_free(solution);
    touchref_fixture_free(fixture);
}

int main(int count, char **given)
{
    if (count == 2 && strcmp(given[1], "plugins") == 0) {
        print_names("fixture", touchref_fixture_kind);
        print_names("solver", touchref_solver_name);
        print_names("dialect", touchref_dialect_name);
        return 0;
    }
    if (count >= 4 && strcmp(given[1], "locate") == 0) {
        return locate_file(given[2], given[3], count > 4 ? given[4] : NULL);
    }
    if (count == 3 && strcmp(given[1], "all") == 0) {
        char *text = read_file(given[2]);
        right_calls(text);
        wrong_calls();
        threads();
        free(text);
        return failures == 0 ? 0 : 1;
    }
    return 9;
}
