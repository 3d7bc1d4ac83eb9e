/* Plant3DOF and Regulator3DOF, linked into this program from their sources, as a sampled-data loop; the positions that
 * are measured go to the standard output at every step, as hexadecimal digits of their bits.
 *
 * two_fmus STEP STEPS PLANT_GUID CONTROLLER_GUID, and on the standard input: the numbers of measurements and of
 * commands, and the value references of each connection, from and to. */

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

#define FMU(prefix) \
    extern fmi2InstantiateTYPE prefix##fmi2Instantiate; \
    extern fmi2SetupExperimentTYPE prefix##fmi2SetupExperiment; \
    extern fmi2EnterInitializationModeTYPE prefix##fmi2EnterInitializationMode; \
    extern fmi2ExitInitializationModeTYPE prefix##fmi2ExitInitializationMode; \
    extern fmi2GetRealTYPE prefix##fmi2GetReal; \
    extern fmi2SetRealTYPE prefix##fmi2SetReal; \
    extern fmi2DoStepTYPE prefix##fmi2DoStep; \
    extern fmi2FreeInstanceTYPE prefix##fmi2FreeInstance

FMU(Plant3DOF_);
FMU(Regulator3DOF_);

enum { MOST = 20 };

struct Wires {
    unsigned count;
    fmi2ValueReference from[MOST], to[MOST];
};

static void check(int good, const char *what)
{
    if (!good) {
        fprintf(stderr, "%s\n", what);
        exit(1);
    }
}

static void read_wires(struct Wires *wires)
{
    for (unsigned i = 0; i < wires->count; ++i) {
        check(scanf("%u %u", &wires->from[i], &wires->to[i]) == 2, "the value references of a connection");
    }
}

#define START(prefix, component) do { \
    check(component != NULL, #prefix "fmi2Instantiate"); \
    check(prefix##fmi2SetupExperiment(component, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK, "set up"); \
    check(prefix##fmi2EnterInitializationMode(component) == fmi2OK, "enter"); \
    check(prefix##fmi2ExitInitializationMode(component) == fmi2OK, "exit"); \
} while (0)

int main(int argc, char **argv)
{
    const fmi2CallbackFunctions callbacks = {NULL, NULL, NULL, NULL, NULL};
    struct Wires measurements, commands;
    double values[MOST];
    check(argc == 5, "expected a step, a number of steps and two GUIDs");
    double step = strtod(argv[1], NULL);
    check(scanf("%u %u", &measurements.count, &commands.count) == 2 && measurements.count <= MOST
          && commands.count <= MOST, "the numbers of connections");
    read_wires(&measurements);
    read_wires(&commands);
    fmi2Component plant = Plant3DOF_fmi2Instantiate("plant", fmi2CoSimulation, argv[3], NULL, &callbacks, 0, 0);
    fmi2Component controller = Regulator3DOF_fmi2Instantiate("controller", fmi2CoSimulation, argv[4], NULL, &callbacks,
                                                             0, 0);
    START(Plant3DOF_, plant);
    START(Regulator3DOF_, controller);
    for (long k = 0; k < atol(argv[2]); ++k) {
        check(Plant3DOF_fmi2GetReal(plant, measurements.from, measurements.count, values) == fmi2OK, "measure");
        for (unsigned i = 0; i < measurements.count; ++i) {
            uint64_t bits;
            memcpy(&bits, &values[i], sizeof bits);
            printf("%016" PRIx64 "%c", bits, i + 1 < measurements.count ? ' ' : '\n');
        }
        check(Regulator3DOF_fmi2SetReal(controller, measurements.to, measurements.count, values) == fmi2OK, "set");
        check(Regulator3DOF_fmi2DoStep(controller, k * step, step, fmi2True) == fmi2OK, "step of the controller");
        check(Regulator3DOF_fmi2GetReal(controller, commands.from, commands.count, values) == fmi2OK, "command");
        check(Plant3DOF_fmi2SetReal(plant, commands.to, commands.count, values) == fmi2OK, "set");
        check(Plant3DOF_fmi2DoStep(plant, k * step, step, fmi2True) == fmi2OK, "step of the plant");
    }
    Regulator3DOF_fmi2FreeInstance(controller);
    Plant3DOF_fmi2FreeInstance(plant);
    return 0;
}
