"""FMUs in C that do what no FMU should: the PD controller of the examples, with a fault in it."""

import shutil
import zipfile
from pathlib import Path

from example_builds import EXAMPLES, require_compiler, script

from maglev.cosim.port_map import read_port_maps
from maglev.experiment.ports.replacement import Replacement
from maglev.experiment.preparation import Experiment, prepare
from maglev.schema.loading import load_plan

AT = 0.1   # s, time of the step in which the fault shows

# Beginning of a function in the controller's source, and what is put before it or at its beginning.
STEP = "(void)time; (void)keep;\n"
NOW = f"(void)keep;\n    if (time > {AT - 1e-6})"
FREE = "void fmi2FreeInstance(fmi2Component c) { "
LOG = "(void)name; (void)resources; (void)callbacks;"
SAY = ('remembered.logger(NULL, remembered_name, fmi2Warning, "logStatusWarning", "gap is odd at t = %g s", time);\n'
       "    return control(c, step), fmi2Warning;\n")
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
    "warn": [(LOG, "(void)resources; remembered = *callbacks; strncpy(remembered_name, name, 99);"),
             ("static void control", "static fmi2CallbackFunctions remembered;\nstatic char remembered_name[100];\n"
                                     "static void control"),
             (STEP, f"(void)keep;\n    {SAY}")],
}


def faulty(fault: str, folder: Path) -> Path:
    """Build the controller with a fault into a folder; returns its path."""
    require_compiler()
    copy = folder / "sources"
    shutil.copytree(EXAMPLES / "pd_controller_c", copy, dirs_exist_ok=True)
    source = copy / "pd_controller.c"
    text = source.read_text()
    for old, new in FAULTS[fault]:
        assert old in text, f"{fault}: the example has changed"
        text = text.replace(old, new, 1)
    source.write_text(text)
    built: Path = script(copy / "build.py").build(folder)
    return built


def claiming(fmu: Path) -> Path:
    """An FMU beside another one, the same but for the tool that it says it is of: this project's. Returns its path."""
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
    return prepare(plan, fmus, {"controller": Replacement(fmu, ports)}, {}, timeout=timeout)
