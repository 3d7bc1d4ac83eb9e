/* The closed loop in a process without Python. The program loads the FMUs of the 3-DOF stage and of its regulator,
 * steps them in turn, and writes positions as CSV.
 *
 *     cc -std=c99 -O2 -I <fmpy>/c-code run.c -o run -ldl -lm
 *     ./run Plant3DOF Regulator3DOF 3 > positions.csv
 *
 * Its arguments are folders of unpacked FMUs and the time to run, s. Linux only: dlopen, binaries/linux64. */

#include <dlfcn.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#define STEP 0.2e-3   /* s, sample time of the regulator */

typedef struct {
    char text[1 << 20];   /* modelDescription.xml */
    fmi2Component component;
    fmi2SetRealTYPE *set_real;
    fmi2GetRealTYPE *get_real;
    fmi2DoStepTYPE *do_step;
    fmi2TerminateTYPE *terminate;
    fmi2FreeInstanceTYPE *free_instance;
} Fmu;

static void fail(const char *what, const char *detail) {
    fprintf(stderr, "run: %s: %s\n", what, detail ? detail : "");
    exit(1);
}

static void check(fmi2Status status, const char *what) {
    if (status > fmi2Warning) fail(what, "refused");
}

static void log_message(fmi2ComponentEnvironment env, fmi2String name, fmi2Status status, fmi2String category,
                        fmi2String message, ...) {
    va_list rest;
    (void)env; (void)status; (void)category;
    va_start(rest, message);
    fprintf(stderr, "%s: ", name);
    vfprintf(stderr, message, rest);
    fputc('\n', stderr);
    va_end(rest);
}

/* Value of an XML attribute behind a place in the text. */
static void attribute(const char *from, const char *name, char *value, size_t size) {
    const char *begin = strstr(from, name), *end;
    if (begin == NULL) fail("modelDescription.xml has no", name);
    begin += strlen(name);
    end = strchr(begin, '"');
    if (end == NULL || (size_t)(end - begin) >= size) fail("modelDescription.xml: too long", name);
    memcpy(value, begin, (size_t)(end - begin));
    value[end - begin] = '\0';
}

/* Value reference of a variable by its name: its attribute is in the same tag. */
static fmi2ValueReference reference(const Fmu *fmu, const char *name) {
    char key[128], value[32];
    const char *tag;
    snprintf(key, sizeof key, " name=\"%s\"", name);
    tag = strstr(fmu->text, key);
    if (tag == NULL) fail("there is no variable", name);
    while (*tag != '<') tag--;
    attribute(tag, "valueReference=\"", value, sizeof value);
    return (fmi2ValueReference)strtoul(value, NULL, 10);
}

static void *symbol(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (found == NULL) fail("no function", name);
    return found;
}

static void set_real(Fmu *fmu, const char *name, double value) {
    fmi2ValueReference vr = reference(fmu, name);
    check(fmu->set_real(fmu->component, &vr, 1, &value), name);
}

static void load(Fmu *fmu, const char *folder, const fmi2CallbackFunctions *callbacks, const double *start) {
    char path[4096], guid[128], identifier[128];
    size_t length;
    void *library;
    FILE *file;

    snprintf(path, sizeof path, "%s/modelDescription.xml", folder);
    if ((file = fopen(path, "rb")) == NULL) fail("cannot open", path);
    length = fread(fmu->text, 1, sizeof fmu->text - 1, file);
    fmu->text[length] = '\0';
    fclose(file);
    attribute(fmu->text, "guid=\"", guid, sizeof guid);
    attribute(fmu->text, "modelIdentifier=\"", identifier, sizeof identifier);
    snprintf(path, sizeof path, "%s/binaries/linux64/%s.so", folder, identifier);
    if ((library = dlopen(path, RTLD_NOW | RTLD_LOCAL)) == NULL) fail("dlopen", dlerror());
    fmu->set_real = (fmi2SetRealTYPE *)symbol(library, "fmi2SetReal");
    fmu->get_real = (fmi2GetRealTYPE *)symbol(library, "fmi2GetReal");
    fmu->do_step = (fmi2DoStepTYPE *)symbol(library, "fmi2DoStep");
    fmu->terminate = (fmi2TerminateTYPE *)symbol(library, "fmi2Terminate");
    fmu->free_instance = (fmi2FreeInstanceTYPE *)symbol(library, "fmi2FreeInstance");
    snprintf(path, sizeof path, "file://%s/resources", folder);
    fmu->component = ((fmi2InstantiateTYPE *)symbol(library, "fmi2Instantiate"))(
        identifier, fmi2CoSimulation, guid, path, callbacks, fmi2False, fmi2True);
    if (fmu->component == NULL) fail("cannot instantiate", identifier);
    check(((fmi2SetupExperimentTYPE *)symbol(library, "fmi2SetupExperiment"))(
        fmu->component, fmi2False, 0.0, 0.0, fmi2False, 0.0), "fmi2SetupExperiment");
    if (start != NULL) {
        set_real(fmu, "y.position_start", start[0]);
        set_real(fmu, "x.position_start", start[1]);
        set_real(fmu, "z.position_start", start[2]);
    }
    check(((fmi2EnterInitializationModeTYPE *)symbol(library, "fmi2EnterInitializationMode"))(fmu->component),
          "fmi2EnterInitializationMode");
    check(((fmi2ExitInitializationModeTYPE *)symbol(library, "fmi2ExitInitializationMode"))(fmu->component),
          "fmi2ExitInitializationMode");
}

static Fmu plant, regulator;

int main(int argc, char **argv) {
    static const char *const axes[] = {"y", "x", "z"};
    static const char *const commands[] = {"alpha.i_a_cmd", "alpha.i_b_cmd", "alpha.i_c_cmd",
                                           "beta.i_a_cmd", "beta.i_b_cmd", "beta.i_c_cmd"};
    static const double start[] = {25e-3, 0.0, 0.0};   /* m */
    fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    fmi2ValueReference encoder[3], position[3], measured[3], target[3], out[6], in[6];
    double lengths[3], currents[6], goal[3];
    long steps, k;

    if (argc != 4) fail("usage", "run PLANT_FOLDER REGULATOR_FOLDER SECONDS");
    load(&plant, argv[1], &callbacks, start);
    load(&regulator, argv[2], &callbacks, NULL);
    for (int i = 0; i < 3; i++) {
        char name[64];
        snprintf(name, sizeof name, "%s.encoder", axes[i]);   encoder[i] = reference(&plant, name);
        snprintf(name, sizeof name, "%s.position", axes[i]);  position[i] = reference(&plant, name);
        snprintf(name, sizeof name, "%s.measured", axes[i]);  measured[i] = reference(&regulator, name);
        snprintf(name, sizeof name, "%s.reference", axes[i]); target[i] = reference(&regulator, name);
    }
    for (int i = 0; i < 6; i++) {
        out[i] = reference(&regulator, commands[i]);
        in[i] = reference(&plant, commands[i]);
    }
    steps = lround(atof(argv[3]) / STEP);
    puts("time,y,x,z");
    for (k = 0; ; k++) {
        double t = (double)k * STEP;   /* never accumulated */
        check(plant.get_real(plant.component, position, 3, lengths), "positions");
        printf("%.17g,%.17g,%.17g,%.17g\n", t, lengths[0], lengths[1], lengths[2]);
        if (k == steps) break;
        goal[0] = k * STEP < 1.0 - 1e-9 ? 25e-3 : 26e-3;   /* y steps by 1 mm after 1 s */
        goal[1] = goal[2] = 0.0;
        check(plant.get_real(plant.component, encoder, 3, lengths), "encoders");
        check(regulator.set_real(regulator.component, measured, 3, lengths), "measurements");
        check(regulator.set_real(regulator.component, target, 3, goal), "references");
        check(regulator.do_step(regulator.component, t, STEP, fmi2True), "a step of the regulator");
        check(regulator.get_real(regulator.component, out, 6, currents), "commands");
        check(plant.set_real(plant.component, in, 6, currents), "commands");
        check(plant.do_step(plant.component, t, STEP, fmi2True), "a step of the plant");
    }
    regulator.terminate(regulator.component);
    plant.terminate(plant.component);
    regulator.free_instance(regulator.component);
    plant.free_instance(plant.component);
    return 0;
}
