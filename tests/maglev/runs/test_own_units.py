"""Units that an FMU declares itself, by SI base units and a factor: understood wherever a scenario names them."""

import zipfile
from pathlib import Path

import numpy as np
import pytest
from command_line import error_line
from command_line import maglev as command
from written_controllers import trial

import maglev
from maglev.files.fmi_units import exponents, unit_text

# An FMU whose mass is in stones and whose force is in ponds: it counts in them, for its numbers are the same.
STONE, POND = 6.35029318, 9.80665e-3
UNITS = f"""<UnitDefinitions>
<Unit name="st"><BaseUnit kg="1" factor="{STONE}"/></Unit>
<Unit name="p"><BaseUnit kg="1" m="1" s="-2" factor="{POND}"/></Unit>"""
FORCED = """
[fmus.plant]
file = "theirs.fmu"
start = { "v.position_start" = "20 mm", "h.position_start" = "0 mm", "v.mass" = "4.5 st" }
[[signals]]
to = "plant.h.force"
kind = "steps"
times = [0, 0.05]
values = ["0 p", "0.5 p"]
"""


def theirs(folder: Path, fmus: Path) -> Path:
    """A copy of the plant with units of its own."""
    path = folder / "theirs.fmu"
    with zipfile.ZipFile(fmus / "Plant2DOF.fmu") as ours, zipfile.ZipFile(path, "w") as made:
        for entry in ours.infolist():
            content = ours.read(entry)
            if entry.filename == "modelDescription.xml":
                text = content.decode().replace("<UnitDefinitions>", UNITS)
                for unit, own in (("kg", "st"), ("N", "p")):
                    assert f'unit="{unit}"' in text
                    text = text.replace(f'unit="{unit}"', f'unit="{own}"')
                content = text.encode()
            made.writestr(entry, content)
    return path


def test_signals_and_start_values_in_units_of_the_fmu(fastest_fmus: Path, tmp_path: Path) -> None:
    theirs(tmp_path, fastest_fmus)
    path = tmp_path / "forced.toml"
    base = trial(tmp_path).read_text().replace("0.4 s", "0.1 s")
    path.write_text(base.replace("[fmus.plant.start]", "[fmus.plant.before]") .split("[fmus.plant.before]")[0]
                    + FORCED + "[[signals]]" + base.split("[[signals]]", 1)[1])
    own = maglev.run(path, fmus=fastest_fmus)
    path.write_text(path.read_text().replace('file = "theirs.fmu"', 'model = "Plant2DOF"').replace(" st", " kg")
                    .replace(" p\"", " N\""))
    ours = maglev.run(path, fmus=fastest_fmus)
    assert np.ptp(ours["plant.h.position"]) > 1e-5
    assert own["plant.h.position"] == pytest.approx(ours["plant.h.position"], abs=1e-9)   # the factors are rounded
    assert own.units["plant.v.position"] == "m"
    assert own.parameters["plant.v.mass"] == pytest.approx(4.5 * STONE)   # in SI, as everything else
    path.write_text(path.read_text().replace("4.5 kg", "4.5 st"))
    assert "unknown unit 'st'" in error_line(command("run", path, "--fmus", fastest_fmus))
    line = error_line(command("run", trial(tmp_path), "--plant", tmp_path / "theirs.fmu", "--fmus", fastest_fmus,
                              "--set", "plant.v.mass=4.5stones"))
    assert "unknown unit 'stones', which plant does not declare by SI base units either; nearest is 'st'" in line


def test_a_unit_has_the_name_of_its_exponents() -> None:
    for unit in ("N", "V", "Ohm", "kg/(m.s3)", "m3", "1/(s2.rad)", "A.rad/s"):
        assert exponents(unit_text(exponents(unit))) == exponents(unit)
    assert unit_text(exponents("kg.m2/s3/A")) == "V"
    assert unit_text({}) == "1"
