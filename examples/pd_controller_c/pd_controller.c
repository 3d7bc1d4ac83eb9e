/* PD controller of the 2-DOF stage as an FMI 2.0 co-simulation FMU: the complete code.
 *
 * Lengths are in mm and currents in A. The gap grows downwards; a larger direct current lowers the mover, and without
 * control it falls, or sticks to the stator, within a tenth of a second. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#define GUID "{6f4d0d3c-2dc5-4a55-8f64-pd-controller-c}"   /* as in modelDescription.xml */

static const double PI = 3.14159265358979323846;
static const double POLE_PITCH = 57.15;      /* mm */
static const double HOLDING = -0.25;         /* A, direct current that holds the mover at a gap of 20 mm */
static const double HOLDING_SLOPE = -0.415;  /* A/mm, its slope over the gap */
static const double GAP_STIFFNESS = 1435.0;  /* 1/s2, instability of the gap at 20 mm */
static const double GAP_GAIN = 3432.0;       /* mm/(s2 A), acceleration by the direct current there */
static const double TRAVEL_GAIN = -6680.0;   /* mm/(s2 A), acceleration by the quadrature current there */
static const double FILTER_TIME = 1.5e-3;    /* s, of the velocities: a step of the encoder is not a velocity */
static const double LARGEST = 6.0;           /* A */

enum { GAP, TRAVEL, GAP_SET, TRAVEL_SET, CURRENT_U, CURRENT_V, CURRENT_W, BANDWIDTH, DAMPING, VARIABLES };

typedef struct {
    double value[VARIABLES];
    double last_gap, last_travel;           /* mm, at the step before */
    double gap_rate, travel_rate;           /* mm/s, filtered */
    int running;
} Controller;

static double limited(double current) { return fmax(-LARGEST, fmin(LARGEST, current)); }

static void control(Controller *c, double dt) {
    double *x = c->value;
    double w = x[BANDWIDTH], damping = 2.0 * x[DAMPING] * w, follow = dt / (FILTER_TIME + dt);
    double gap_error = x[GAP] - x[GAP_SET], travel_error = x[TRAVEL] - x[TRAVEL_SET], holding, i_d, i_q, angle;

    if (!c->running) {
        c->last_gap = x[GAP];
        c->last_travel = x[TRAVEL];
        c->running = 1;
    }
    c->gap_rate += follow * ((x[GAP] - c->last_gap) / dt - c->gap_rate);
    c->travel_rate += follow * ((x[TRAVEL] - c->last_travel) / dt - c->travel_rate);
    c->last_gap = x[GAP];
    c->last_travel = x[TRAVEL];

    holding = HOLDING + HOLDING_SLOPE * (x[GAP_SET] - 20.0);
    i_d = limited(holding - ((GAP_STIFFNESS + w * w) * gap_error + damping * c->gap_rate) / GAP_GAIN);
    i_q = limited(-(w * w * travel_error + damping * c->travel_rate) / TRAVEL_GAIN);
    angle = PI / POLE_PITCH * (x[TRAVEL] - POLE_PITCH / 2.0);
    x[CURRENT_U] = cos(angle) * i_d - sin(angle) * i_q;
    x[CURRENT_V] = cos(angle - 2.0 * PI / 3.0) * i_d - sin(angle - 2.0 * PI / 3.0) * i_q;
    x[CURRENT_W] = cos(angle + 2.0 * PI / 3.0) * i_d - sin(angle + 2.0 * PI / 3.0) * i_q;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    static const double start[VARIABLES] = {20.0, 0.0, 20.0, 0.0, 0.0, 0.0, 0.0, 60.0, 0.9};
    Controller *c = type == fmi2CoSimulation && strcmp(guid, GUID) == 0 ? calloc(1, sizeof *c) : NULL;
    (void)name; (void)resources; (void)callbacks; (void)visible; (void)logging;
    if (c != NULL) memcpy(c->value, start, sizeof start);
    return c;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2Reset(fmi2Component c) {
    Controller *fresh = fmi2Instantiate("", fmi2CoSimulation, GUID, "", NULL, 0, 0);
    if (fresh == NULL) return fmi2Error;
    memcpy(c, fresh, sizeof *fresh);
    free(fresh);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= VARIABLES) return fmi2Error;
        value[i] = ((Controller *)c)->value[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= VARIABLES) return fmi2Error;
        ((Controller *)c)->value[vr[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean keep) {
    (void)time; (void)keep;
    if (!(step > 0.0)) return fmi2Error;
    control(c, step);
    return fmi2OK;
}

#include "fmi2_unused.h"
