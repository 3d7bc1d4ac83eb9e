/* The magnetic bearing of bearing.py as an FMI 2.0 co-simulation FMU: the same states, ports and numbers, in C.
 *
 *     python ../pd_controller_c/build.py .
 *     maglev run levitate.toml --plant bearing.fmu
 */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#define GUID "{8f1c2a6e-5d0b-4f3e-9b57-magnetic-bearing-c}"   /* as in modelDescription.xml */

static const double GRAVITY = 9.81;            /* m/s2 */
static const double CORE = 1.13e-5;            /* mu0 N^2 A, H m */
static const double RESISTANCE = 1.0;          /* Ohm */
static const double LARGEST_VOLTAGE = 150.0;   /* V, of the amplifiers */
static const double AMPLIFIER = 80.0;          /* V/A, their gain on the error of the current */
enum { PARTS = 4 };                            /* integration steps of a communication step */

enum { X, Y, AXES };
enum { PLUS, MINUS, MAGNETS };

/* Value references: commands, forces, positions, currents, parameters. The Boolean `touched` has a 0 of its own. */
enum { COMMAND = 0, FORCE = 4, POSITION = 6, CURRENT = 8, START = 12, MASS = 14, AIR_GAP, CLEARANCE, TURNING,
       ECCENTRICITY, VARIABLES };

/* States of an axis: m, m/s, V s of each magnet. */
enum { PLACE, SPEED, FLUX, STATES = FLUX + MAGNETS };

typedef struct {
    double value[VARIABLES];
    double state[AXES][STATES];
    fmi2Boolean touched;
    fmi2CallbackLogger log;
    fmi2ComponentEnvironment environment;
    char name[100];
} Bearing;

/* Rates of all states at a time (s); sets the currents. */
static void derive(Bearing *b, double time, double state[AXES][STATES], double rate[AXES][STATES]) {
    double *v = b->value, angle = v[TURNING] * time;
    double unbalance = v[MASS] * v[ECCENTRICITY] * v[TURNING] * v[TURNING];
    double load[AXES] = {unbalance * cos(angle), unbalance * sin(angle) - v[MASS] * GRAVITY};

    for (int axis = X; axis < AXES; axis++) {
        double force[MAGNETS];
        for (int magnet = PLUS; magnet < MAGNETS; magnet++) {
            double gap = v[AIR_GAP] + (magnet == PLUS ? -1.0 : 1.0) * state[axis][PLACE];
            double flux = state[axis][FLUX + magnet], *current = &v[CURRENT + MAGNETS * axis + magnet];
            *current = 2.0 * gap * flux / CORE;
            force[magnet] = flux * flux / CORE;
            rate[axis][FLUX + magnet] = -RESISTANCE * *current + fmax(-LARGEST_VOLTAGE, fmin(
                LARGEST_VOLTAGE, AMPLIFIER * (v[COMMAND + MAGNETS * axis + magnet] - *current)));
        }
        rate[axis][PLACE] = state[axis][SPEED];
        rate[axis][SPEED] = (force[PLUS] - force[MINUS] + v[FORCE + axis] + load[axis]) / v[MASS];
    }
}

/* Set the outputs. */
static void measure(Bearing *b, double time) {
    double rate[AXES][STATES];
    derive(b, time, b->state, rate);
    b->value[POSITION + X] = b->state[X][PLACE];
    b->value[POSITION + Y] = b->state[Y][PLACE];
    b->touched = hypot(b->state[X][PLACE], b->state[Y][PLACE]) > b->value[CLEARANCE];
}

/* Place the rotor, at rest and without flux. */
static void place(Bearing *b) {
    memset(b->state, 0, sizeof b->state);
    b->state[X][PLACE] = b->value[START + X];
    b->state[Y][PLACE] = b->value[START + Y];
    measure(b, 0.0);
}

/* The classical Runge-Kutta method from a time over h (s). */
static void integrate(Bearing *b, double time, double h) {
    static const double weights[] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0}, ahead[] = {0.5, 0.5, 1.0, 0.0};
    static const double at[] = {0.0, 0.5, 0.5, 1.0};
    double point[AXES][STATES], rate[AXES][STATES], end[AXES][STATES];

    memcpy(point, b->state, sizeof point);
    memcpy(end, b->state, sizeof end);
    for (int slope = 0; slope < 4; slope++) {
        derive(b, time + at[slope] * h, point, rate);
        for (int axis = X; axis < AXES; axis++) {
            for (int k = PLACE; k < STATES; k++) {
                end[axis][k] += weights[slope] * h * rate[axis][k];
                point[axis][k] = b->state[axis][k] + ahead[slope] * h * rate[axis][k];
            }
        }
    }
    memcpy(b->state, end, sizeof end);
}

static void reset(Bearing *b) {
    static const double start[VARIABLES] = {
        [START + Y] = -0.15e-3, [MASS] = 4.0, [AIR_GAP] = 0.4e-3, [CLEARANCE] = 0.2e-3, [ECCENTRICITY] = 1.0e-6};
    memcpy(b->value, start, sizeof start);
    place(b);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    Bearing *b = type == fmi2CoSimulation && strcmp(guid, GUID) == 0 ? calloc(1, sizeof *b) : NULL;
    (void)resources; (void)visible; (void)logging;
    if (b == NULL) return NULL;
    b->log = callbacks->logger;
    b->environment = callbacks->componentEnvironment;
    strncpy(b->name, name, sizeof b->name - 1);
    reset(b);
    return b;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2Reset(fmi2Component c) { reset(c); return fmi2OK; }

fmi2Status fmi2ExitInitializationMode(fmi2Component c) { place(c); return fmi2OK; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= VARIABLES) return fmi2Error;
        value[i] = ((Bearing *)c)->value[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= VARIABLES) return fmi2Error;
        ((Bearing *)c)->value[vr[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != 0) return fmi2Error;
        value[i] = ((Bearing *)c)->touched;
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean keep) {
    Bearing *b = c;
    (void)keep;
    if (!(step > 0.0)) return fmi2Error;
    for (int part = 0; part < PARTS; part++) integrate(b, time + part * (step / PARTS), step / PARTS);
    measure(b, time + step);
    if (isfinite(b->state[X][PLACE]) && isfinite(b->state[Y][PLACE])) return fmi2OK;
    b->log(b->environment, b->name, fmi2Error, "error", "x.position = %g m, y.position = %g m at t = %g s, expected "
           "finite numbers", b->state[X][PLACE], b->state[Y][PLACE], time + step);
    return fmi2Error;
}

#define HAS_START
#define HAS_BOOLEAN
#include "fmi2_unused.h"
