"""The 3-DOF plant with arrays, an FMU of FMI 3.0 to try an importer with.

    python examples/array_plant.py FOLDER

writes FOLDER/ArrayPlant3DOF.fmu. Elements of `position`, `velocity`, `encoder`, `position_start`, `force` and `mass`
are the axes y, x, z. The currents `i_cmd` and `i` have a row for each motor and a column for each phase.
"""

import sys
from pathlib import Path

from maglev.descriptions.own_fmus import definition, project
from maglev.fmi.arrays import with_arrays
from maglev.fmi.definition import Array
from maglev.fmi.native_build import build_native_fmu

AXES, MOTORS, PHASES = "yxz", ("alpha", "beta"), "abc"

ARRAYS = [
    *(Array(name, f"{name} of the axes y, x, z", (3,), tuple(f"{axis}.{name}" for axis in AXES))
      for name in ("position", "velocity", "encoder", "position_start", "force", "mass")),
    *(Array(name, f"{meaning} of the motors alpha, beta; phases a, b, c", (2, 3),
            tuple(f"{motor}.{name.replace('i', f'i_{phase}', 1)}" for motor in MOTORS for phase in PHASES))
      for name, meaning in (("i_cmd", "Commanded currents"), ("i", "Currents")))]

if __name__ == "__main__":
    print(build_native_fmu(with_arrays(definition("Plant3DOF"), "ArrayPlant3DOF", ARRAYS), project(),
                           Path(sys.argv[1]), host_only=True, fmi=3))
