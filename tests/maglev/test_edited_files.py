"""Files that are edited in place: their content decides, not their size and time."""

import os
import zipfile
from pathlib import Path
from threading import Thread

import pytest

from maglev.cosim.fmu import read_description
from maglev.files.cache import digest_at
from maglev.scenario.loading import load_plan
from maglev.user.source import FmuFile

TIME = 1_700_000_000_000_000_000   # ns

SCENARIO = """
name = "hold"
title = "Hold"
step = "1 ms"
stop_time = "1 s"
[fmus.plant]
model = "Plant3DOF"
start = { "y.mass" = 7.0 }
"""

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Small" guid="{0}">
<CoSimulation modelIdentifier="Small"/>
<ModelVariables><ScalarVariable name="y" valueReference="0"><Real/></ScalarVariable></ModelVariables>
<ModelStructure/>
</fmiModelDescription>"""


def edit(path: Path, content: bytes) -> None:
    """Write into a file in place, and give it back its time."""
    with path.open("r+b" if path.exists() else "wb") as file:
        file.write(content)
    os.utime(path, ns=(TIME, TIME))


def write_fmu(path: Path, guid: str) -> None:
    other = path.with_suffix(".zip")
    with zipfile.ZipFile(other, "w") as archive:
        archive.writestr(zipfile.ZipInfo("modelDescription.xml"), DESCRIPTION.format(guid))
    edit(path, other.read_bytes())


@pytest.mark.parametrize("extended", [False, True])
def test_a_scenario_that_is_edited_in_place_is_read_again(tmp_path: Path, extended: bool) -> None:
    base = tmp_path / "hold.toml"
    edit(base, SCENARIO.encode())
    path = base
    if extended:
        path = tmp_path / "longer.toml"
        path.write_text('extends = "hold.toml"\nname = "longer"\n')
    assert load_plan(path).fmus["plant"].start["y.mass"].value == 7.0
    edit(base, SCENARIO.replace("7.0", "8.0").encode())
    assert load_plan(path).fmus["plant"].start["y.mass"].value == 8.0


def test_an_fmu_that_is_edited_in_place_is_read_and_copied_again(tmp_path: Path) -> None:
    path = tmp_path / "small.fmu"
    write_fmu(path, "first")
    before = path.stat()
    assert read_description("plant", path).guid == "first"
    copy = FmuFile(path).copy()
    write_fmu(path, "other")
    assert (path.stat().st_mtime_ns, path.stat().st_size, path.stat().st_ino) == (
        before.st_mtime_ns, before.st_size, before.st_ino)
    assert read_description("plant", path).guid == "other"
    assert FmuFile(path).copy() != copy


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="a system with named pipes")
def test_the_digest_of_a_pipe_waits_for_nobody(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    digests: list[str] = []
    reader = Thread(target=lambda: digests.append(digest_at(tmp_path / "pipe")), daemon=True)
    reader.start()
    reader.join(10.0)
    assert digests == [""]
