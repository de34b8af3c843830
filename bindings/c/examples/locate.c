/* The worked example of Nederbragt and Ravani: four touches on a cylinder, three on an oblique plane. */

#include <stdio.h>
#include <string.h>

#include <touchref.h>

/* A touch of which no more is known than where it is. */
static touchref_touch touch(const char *surface, double x, double y, double z)
{
    touchref_touch made;
    memset(&made, 0, sizeof made);
    made.surface = surface;
    made.at[0] = x;
    made.at[1] = y;
    made.at[2] = z;
    return made;
}

static void tell(const touchref_solution *solution)
{
    touchref_frame frame;
    touchref_covariance covariance;
    touchref_root root;
    size_t i;

    if (touchref_solution_frame(solution, &frame) != TOUCHREF_OK) {
        return;
    }
    for (i = 0; i < 4; i++) {
        printf("%9.6f %9.6f %9.6f %9.6f\n", frame.matrix[i][0], frame.matrix[i][1], frame.matrix[i][2],
               frame.matrix[i][3]);
    }
    if (touchref_solution_covariance(solution, &covariance)) {
        printf("variance of the origin: %.3g %.3g %.3g\n", covariance.matrix[0][0], covariance.matrix[1][1],
               covariance.matrix[2][2]);
    }
    printf("p = %.3f, condition %.1f\n", touchref_solution_p_value(solution),
           touchref_solution_condition(solution));
    for (i = 0; touchref_solution_root(solution, i, &root) == TOUCHREF_OK; i++) {
        printf("%c misfit %.1f: %s\n", root.selected ? '*' : ' ', root.misfit, root.reason);
    }
    for (i = 0; i < touchref_solution_warning_count(solution); i++) {
        printf("warning: %s\n", touchref_solution_warning_message(solution, i));
    }
}

int main(void)
{
    touchref_fixture *fixture;
    touchref_solution *solution = NULL;
    touchref_error *error;
    touchref_touch touches[7];
    touchref_probe probe = {0.0, 0.0, 0.00005};
    touchref_status status;

    touches[0] = touch("cylinder", 2.9270, 2.0000, 1.6250);
    touches[1] = touch("cylinder", 1.7750, 2.8000, 1.4438);
    touches[2] = touch("cylinder", 1.3730, 2.6000, 3.1166);
    touches[3] = touch("cylinder", 3.5270, 3.2000, 3.1082);
    touches[4] = touch("plane", 2.8250, 2.4000, 4.0395);
    touches[5] = touch("plane", 3.9020, 5.2000, 4.0353);
    touches[6] = touch("plane", 2.0480, 5.2000, 4.7853);

    status = touchref_fixture_new("cylinder-plane", "{\"radius\": 1.0, \"angle_deg\": 45.0}", "mm", &fixture, &error);
    if (status == TOUCHREF_OK) {
        status = touchref_locate(fixture, touches, 7, &probe, NULL, &solution, &error);
    }
    if (status == TOUCHREF_OK) {
        tell(solution);
    } else {
        fprintf(stderr, "%s: %s\n%s\n", touchref_error_code(error), touchref_error_message(error),
                touchref_error_help(error));
    }
    touchref_error_free(error);
    touchref_solution_free(solution);
    touchref_fixture_free(fixture);
    return status;
}
