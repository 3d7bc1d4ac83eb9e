"""FMUs in C that do what no FMU should: the PD controller of the examples, with a fault in it."""

import shutil
import zipfile
from pathlib import Path

from example_builds import EXAMPLES, require_compiler, script

from maglev.cosim.port_map import read_port_maps
from maglev.runs.preparation import Experiment, prepare
from maglev.runs.replacement import Replacement
from maglev.scenario.loading import load_plan
from maglev.user.source import FmuFile

AT = 0.1   # s, time of the step in which the fault shows

# Beginning of a function in the controller's source, and what is put before it or at its beginning.
STEP = "(void)time; (void)keep;\n"
NOW = f"(void)keep;\n    if (time > {AT - 1e-6})"
FREE = "void fmi2FreeInstance(fmi2Component c) { "
LOG = "(void)name; (void)resources; (void)callbacks;"
SAY = ('remembered.logger(NULL, remembered_name, fmi2Warning, "logStatusWarning", "gap is odd at t = %g s", time);\n'
       "    return control(c, step), fmi2Warning;\n")
TERMINATE = "UNUSED(fmi2OK, fmi2Terminate, fmi2Component c)"
# Cuts every file of the run that is mapped, and writes into every pipe but the standard ones.
HELP = """
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

static void cut(const char *what) {
    char line[4096], *name;
    FILE *maps = fopen("/proc/self/maps", "r");
    while (fgets(line, sizeof line, maps)) {
        line[strcspn(line, "\\n")] = 0;
        if ((name = strchr(line, '/')) && strstr(name, what) && truncate(name, 0)) abort();
    }
    fclose(maps);
}

static void each_pipe(const char *text, int closes) {
    struct stat found;
    for (int fd = 3; fd < 64; fd++) {
        if (fstat(fd, &found) || !S_ISFIFO(found.st_mode)) continue;
        if (text && write(fd, text, strlen(text)) < 0) continue;
        if (closes) close(fd);
    }
}

static void control("""
# What makes the file that MARKER names where it is unpickled.
PICKLE = r"cos\nsystem\n(S'touch $MARKER'\ntR.\n"
ASIDE = ("static void control(", HELP)
FAULTS = {
    "none": [],
    "crash": [(STEP, f"{NOW} *(volatile int *)0 = 1;\n")],
    "exit": [(STEP, f"{NOW} exit(0);\n")],
    "hang": [(STEP, f"{NOW} {{ extern unsigned sleep(unsigned); for (;;) sleep(1); }}\n")],   # which takes no processor
    "negative": [(STEP, f"{NOW} return (fmi2Status)-1;\n")],
    "crash when freed": [(FREE, f"{FREE}*(volatile int *)0 = 1; ")],
    "exit when freed": [(FREE, f"{FREE}exit(0); ")],
    "fatal": [(STEP, f"{NOW} return fmi2Fatal;\n"), (FREE, f"{FREE}*(volatile int *)0 = 1; ")],
    "crash when loaded": [(LOG, f"{LOG} *(volatile int *)0 = 1;")],
    "cut the recording": [ASIDE, (STEP, f"{NOW} cut(\"/track\");\n")],
    "cut the counter": [ASIDE, (STEP, f"{NOW} cut(\"/calls\");\n")],
    "cut the recording in the end": [ASIDE, (TERMINATE, "fmi2Status fmi2Terminate(fmi2Component c) "
                                             "{ (void)c; cut(\"/track\"); return fmi2OK; }")],
    "write into pipes": [ASIDE, (STEP, f"{NOW} each_pipe(\"a line of my log\\n\", 0);\n")],
    "close pipes": [ASIDE, (STEP, f"{NOW} each_pipe(0, 1);\n")],
    "pickle into pipes": [ASIDE, (STEP, f"{NOW} each_pipe(\"{PICKLE}\", 0);\n")],
    "close pipes and leave a child": [ASIDE, (STEP, f"{NOW} {{ each_pipe(0, 1);\n"
                                                    "fork(); for (;;) sleep(1); }\n")],
    "error in the end": [(TERMINATE, "UNUSED(fmi2Error, fmi2Terminate, fmi2Component c)")],
    "crash in the end": [(TERMINATE, "fmi2Status fmi2Terminate(fmi2Component c) "
                                     "{ (void)c; return *(volatile int *)0 ? fmi2OK : fmi2Error; }")],
    **{what: [(LOG, "(void)resources; remembered = *callbacks; strncpy(remembered_name, name, 99);"),
              ("static void control", "static fmi2CallbackFunctions remembered;\nstatic char remembered_name[100];\n"
                                      "static void control"),
              (STEP, f"(void)keep;\n    {SAY}".replace("NULL, remembered_name", whom))]
       for what, whom in {"warn": "NULL, remembered_name", "warn without a name": "NULL, NULL",
                          "warn in another name": 'remembered.componentEnvironment, "Component1"'}.items()},
}


def faulty(fault: str, folder: Path) -> Path:
    """Build the controller with a fault into a folder; returns its path."""
    require_compiler()
    copy = folder / "sources"
    shutil.copytree(EXAMPLES / "pd_controller_c", copy, dirs_exist_ok=True)
    for old, new in FAULTS[fault]:
        found = [source for source in copy.glob("*.[ch]") if old in source.read_text()]
        assert found, f"{fault}: the example has changed"
        found[0].write_text(found[0].read_text().replace(old, new, 1))
    built: Path = script(copy / "build.py").build(folder)
    return built


def claiming(fmu: Path) -> Path:
    """An FMU next to another one, the same except for its generation tool: this project. Returns its path."""
    claims = fmu.with_name(f"claiming_{fmu.name}")
    with zipfile.ZipFile(fmu) as archive, zipfile.ZipFile(claims, "w") as changed:
        for entry in archive.namelist():
            data = archive.read(entry)
            if entry == "modelDescription.xml":
                assert b'"by hand"' in data, "the example has changed"
                data = data.replace(b'"by hand"', b'"Maglev FMUs 0.1.0"')
            changed.writestr(entry, data)
    return claims


def faulty_run(fmu: Path, fmus: Path, stop_time: float = 0.3, timeout: float = 60.0) -> Experiment:
    """The 2-DOF stage under that controller."""
    ports = read_port_maps(EXAMPLES / "pd_controller_c" / "ports.toml")["controller"]
    plan = load_plan("2dof-step-1-nonlinear").model_copy(update={"stop_time": stop_time})
    return prepare(plan, fmus, {"controller": Replacement(FmuFile(fmu), ports)}, {}, {"timeout": timeout})
