/* Loads the library of an FMU, steps it with the inputs that it reads, and writes the outputs, all of them as bits:
 * for the library of one system run on another, and for sources that another compiler has seen.
 *
 * replay LIBRARY GUID, and on the standard input: steps, step size (s), number of inputs and of outputs, their value
 * references, and for every step the inputs; doubles as 16 hexadecimal digits. */

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

#ifdef _WIN32
#include <windows.h>
static void *opened(const char *path) { return (void *)LoadLibraryA(path); }
static void *found(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
static const char *problem(void) { return "LoadLibrary or GetProcAddress failed"; }
#else
#include <dlfcn.h>
static void *opened(const char *path) { return dlopen(path, RTLD_NOW); }
static void *found(void *library, const char *name) { return dlsym(library, name); }
static const char *problem(void) { return dlerror(); }
#endif

enum { MOST = 200 };

static void check(int good, const char *what)
{
    if (!good) {
        fprintf(stderr, "%s\n", what);
        exit(1);
    }
}

static void logger(void *environment, fmi2String instance, fmi2Status status, fmi2String category, fmi2String format,
                   ...)
{
    va_list arguments;
    (void)environment;
    fprintf(stderr, "%s %s %d: ", instance, category, (int)status);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fprintf(stderr, "\n");
}

static double read_double(void)
{
    uint64_t bits = 0;
    double value;
    check(scanf("%" SCNx64, &bits) == 1, "a double is missing");
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void *function(void *library, const char *name)
{
    void *address = found(library, name);
    check(address != NULL, name);
    return address;
}

#define FUNCTION(name) name##TYPE *name = (name##TYPE *)function(library, #name)

int main(int argc, char **argv)
{
    unsigned steps, inputs, outputs;
    fmi2ValueReference of_inputs[MOST], of_outputs[MOST];
    double values[MOST];
    const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    check(argc == 3, "expected a library and a GUID");
    void *library = opened(argv[1]);
    check(library != NULL, problem());
    FUNCTION(fmi2Instantiate);
    FUNCTION(fmi2SetupExperiment);
    FUNCTION(fmi2EnterInitializationMode);
    FUNCTION(fmi2ExitInitializationMode);
    FUNCTION(fmi2SetReal);
    FUNCTION(fmi2GetReal);
    FUNCTION(fmi2DoStep);
    FUNCTION(fmi2Terminate);
    FUNCTION(fmi2FreeInstance);

    check(scanf("%u", &steps) == 1, "the number of steps is missing");
    double size = read_double();
    check(scanf("%u %u", &inputs, &outputs) == 2 && inputs <= MOST && outputs <= MOST, "the numbers of variables");
    for (unsigned i = 0; i < inputs; ++i) {
        check(scanf("%u", &of_inputs[i]) == 1, "a value reference is missing");
    }
    for (unsigned i = 0; i < outputs; ++i) {
        check(scanf("%u", &of_outputs[i]) == 1, "a value reference is missing");
    }
    fmi2Component c = fmi2Instantiate("replay", fmi2CoSimulation, argv[2], "", &callbacks, fmi2False, fmi2True);
    check(c != NULL, "fmi2Instantiate");
    check(fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK, "fmi2SetupExperiment");
    check(fmi2EnterInitializationMode(c) == fmi2OK, "fmi2EnterInitializationMode");
    check(fmi2ExitInitializationMode(c) == fmi2OK, "fmi2ExitInitializationMode");
    for (unsigned k = 0; k < steps; ++k) {
        for (unsigned i = 0; i < inputs; ++i) {
            values[i] = read_double();
        }
        check(fmi2SetReal(c, of_inputs, inputs, values) == fmi2OK, "fmi2SetReal");
        check(fmi2DoStep(c, k * size, size, fmi2True) == fmi2OK, "fmi2DoStep");
        check(fmi2GetReal(c, of_outputs, outputs, values) == fmi2OK, "fmi2GetReal");
        for (unsigned i = 0; i < outputs; ++i) {
            uint64_t bits;
            memcpy(&bits, &values[i], sizeof bits);
            printf("%016" PRIx64 "%c", bits, i + 1 < outputs ? ' ' : '\n');
        }
    }
    check(fmi2Terminate(c) == fmi2OK, "fmi2Terminate");
    fmi2FreeInstance(c);
    return 0;
}
