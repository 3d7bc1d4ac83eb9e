"""What is done of a study: one writer at a time, and nothing is believed that is not as it was written."""

import os
import shutil
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from command_line import error_line
from command_line import maglev as command
from facts import raises, require_facts
from numpy.typing import NDArray
from tiny_study import planned, scenario, simulate_samples

from maglev.files.errors import Interrupted, ScenarioError
from maglev.many import study_run as running
from maglev.many.samples import Batch, BatchResult, Job
from maglev.many.study_parts import Parts
from maglev.many.study_plan import PlannedStudy

HOLDER = """
import sys, time
sys.path[:] = {path!r}
from pathlib import Path
from maglev.many.study_parts import Parts
with Parts(Path({folder!r}), "key").alone():
    print("locked", flush=True)
    time.sleep(600.0)
"""

STUDY = """
name = "it"
scenario = "tiny.toml"
[[vary]]
set = "plant.v.mass"
kind = "list"
values = [4.0]
"""

TUNING = """
name = "it"
scenario = "tiny.toml"
minimise = ["rms error of h"]
[[search]]
set = ["plant.h.position_start"]
low = "-1 mm"
high = "1 mm"
"""


def test_a_part_lands_in_its_folder_wherever_the_process_is_meanwhile(tmp_path: Path,
                                                                      monkeypatch: pytest.MonkeyPatch) -> None:
    """A thread that loads an FMU changes the working folder for a moment, and a part may be written in it."""
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    parts = Parts(Path("study.parts"), "key")
    parts.begin()
    monkeypatch.chdir(tmp_path / "elsewhere")
    parts.write("samples-0000000.parquet", b"content")
    monkeypatch.chdir(tmp_path)
    assert parts.read("samples-0000000.parquet") == b"content"
    assert not [*(tmp_path / "elsewhere").iterdir()]


def test_a_second_writer_is_refused_until_the_first_ends_however_it_does(tmp_path: Path) -> None:
    folder = tmp_path / "study.parts"
    holder = subprocess.Popen([sys.executable, "-c", HOLDER.format(path=sys.path, folder=str(folder))],
                              stdout=subprocess.PIPE, text=True)
    assert holder.stdout is not None
    assert holder.stdout.readline() == "locked\n"
    with raises(ScenarioError, folder, "another process"), \
            Parts(folder, "key").alone():
        pass
    with Parts(tmp_path / "other.parts", "key").alone():   # another study into the same results
        pass
    holder.kill()
    holder.communicate()
    with Parts(folder, "key").alone(), raises(ScenarioError, folder, "another process"), \
            Parts(folder, "other").alone():
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("word", "text", "more"), [
    ("study", STUDY, []), ("tune", TUNING, []), ("study", None, ["--vary", "plant.v.mass=4,5", "--name", "it"])])
def test_a_second_command_is_refused(word: str, text: str | None, more: list[str], fastest_fmus: Path,
                                     tmp_path: Path) -> None:
    path = scenario(tmp_path)
    if text is not None:
        path = tmp_path / "it.toml"
        path.write_text(text)
    with Parts(tmp_path / "it.parts", "key").alone():
        result = command(word, path, *more, "--fmus", fastest_fmus, "--out", tmp_path, "--jobs", "1")
    assert "it.parts: another process is writing there" in error_line(result)


Damage = Callable[[Path], None]


SIMULATED: dict[tuple[str, int], BatchResult] = {}   # by key of a study and first sample: what is kept is the subject


class Here:
    """Studies in this process, instead of those next to it; how many samples were run, for the first time or again."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch):
        self.simulated = 0
        self.said: list[str] = []
        monkeypatch.setattr(running, "runners", lambda *_: nullcontext(self.simulate))

    def simulate(self, job: Job, batches: list[Batch], values: NDArray[Any],
            store: Callable[[BatchResult], None]) -> None:
        for batch in batches:
            place = job.key, batch.first
            if place not in SIMULATED:
                SIMULATED[place] = simulate_samples(job, batch.first, values[batch.first:batch.last])
            store(SIMULATED[place])
            self.simulated += batch.last - batch.first

    def study(self, study: PlannedStudy, out: Path, resume: bool = False,
              watch: Callable[[int, int], None] = lambda _done, _all: None) -> list[bytes]:
        """Run it; what is in its files."""
        self.simulated = 0
        self.said = []
        path = running.run_study(study, out, 1, None, resume, watch, self.said.append)
        return [file.read_bytes() for file in (path, running.trajectories_path(path))]


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> Here:
    return Here(monkeypatch)


def until(samples: int) -> Callable[[int, int], None]:
    """Interrupt after so many samples."""
    def watch(done: int, _all: int) -> None:
        if done >= samples:
            raise KeyboardInterrupt

    return watch


def the(out: Path, part: str) -> Path:
    path, = (out / "study.parts").glob(f"{part}.*")
    return path


def swapped(out: Path) -> None:
    first, second = the(out, "samples-0000001"), the(out, "samples-0000002")
    kept = first.read_bytes()
    second.replace(first)
    second.write_bytes(kept)


def renamed(out: Path) -> None:
    """A part under the name of another, with the digest of its content."""
    whole = the(out, "trajectories-0000002")
    whole.rename(whole.with_name(whole.name.replace("0000002", "0000001")))
    the(out, "samples-0000002").unlink()


def shortened(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-100])


@pytest.mark.few(3)
@pytest.mark.parametrize(("damage", "again", "broken"), [
    (lambda out: None, 0, 0),
    (lambda out: the(out, "trajectories-0000001").unlink(), 3, 1),
    (lambda out: the(out, "samples-0000001").write_bytes(b""), 3, 1),
    (lambda out: shortened(the(out, "samples-0000002")), 3, 1),
    (lambda out: shortened(the(out, "trajectories-0000002")), 3, 2),   # the file, and what its samples lack
    (lambda out: shutil.copy(the(out, "samples-0000001"), the(out, "samples-0000002")), 3, 1),
    (swapped, 6, 2),
    (renamed, 3, 1),
    (lambda out: the(out, "samples-0000000").write_text("a,b\n1,2\n"), 3, 1),
    (lambda out: (out / "study.parts" / "samples-0000001.parquet").write_bytes(b"PAR1"), 0, 1)],
    ids=["nothing", "deleted trajectories", "empty", "truncated", "truncated trajectories", "copied over another",
         "swapped", "renamed", "foreign", "another file"])
def test_missing_or_broken_parts_are_run_again(damage: Damage, again: int, broken: int, here: Here,
                                                 fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, keep=["plant.v.position"])
    assert {batch.last - batch.first for batch in study.batches[:-1]} == {3}
    whole = here.study(study, tmp_path / "whole")
    with raises(Interrupted, "12 of 20"):
        here.study(study, tmp_path / "out", watch=until(12))
    damage(tmp_path / "out")
    assert here.study(study, tmp_path / "out", resume=True) == whole
    assert here.simulated == 8 + again
    assert here.said == ([] if broken == 0 else [
        f"{tmp_path / 'out' / 'study.parts'}: {broken} of the parts are missing or changed; {12 - again} "
        "of 20 samples are complete, the others are run again"])


def test_ignores_parts_of_another_study(here: Here, fastest_fmus: Path, tmp_path: Path) -> None:
    """Parts have the right names and are whole: those of the same study with other masses."""
    study = planned(tmp_path, fastest_fmus, keep=["plant.v.position"])
    other = planned(tmp_path, fastest_fmus, keep=["plant.v.position"], vary=[
        {"set": "plant.v.mass", "kind": "grid", "from": 4.1, "to": 5.0, "number": 20}])
    whole = here.study(study, tmp_path / "whole")
    for each, out in ((study, "out"), (other, "other")):
        with pytest.raises(Interrupted):
            here.study(each, tmp_path / out, watch=until(12))
    for path in (tmp_path / "other" / "study.parts").glob("*-0000001.*"):
        kind = path.name.partition(".")[0]
        the(tmp_path / "out", kind).unlink()
        shutil.copy(path, tmp_path / "out" / "study.parts")
    assert here.study(study, tmp_path / "out", resume=True) == whole
    assert here.simulated == 8 + 3
    assert "2 of the parts are missing or changed; 9 of 20 samples are complete" in here.said[0]


def test_never_merges_parts_that_change_meanwhile(here: Here, fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, keep=["plant.v.position"])
    whole = here.study(study, tmp_path / "whole")

    def meddle(done: int, samples: int) -> None:
        if done == samples:
            shutil.copy(the(tmp_path / "out", "samples-0000003"), the(tmp_path / "out", "samples-0000004"))

    with raises(ScenarioError) as refusal:
        here.study(study, tmp_path / "out", watch=meddle)
    require_facts(refusal.value, the(tmp_path / "out", "samples-0000004"))
    assert not (tmp_path / "out" / "study.parquet").exists()
    assert here.study(study, tmp_path / "out", resume=True) == whole
    assert here.simulated == 3


def flipped(path: Path) -> None:
    """Another bit in the first column."""
    content = bytearray(path.read_bytes())
    content[64] ^= 1
    path.write_bytes(content)


def edited(path: Path) -> None:
    """Another number in the last column of numbers, all else kept."""
    table = pq.read_table(path)
    name = [field.name for field in table.schema if field.type == "double"][-1]
    numbers = [*table[name].to_pylist()[:-1], 9.0]
    pq.write_table(table.set_column(table.column_names.index(name), table.schema.field(name), [numbers]), path)


@pytest.mark.few(2)
@pytest.mark.parametrize("damage", [
    lambda out: edited(out / "study.parquet"), lambda out: edited(out / "study.trajectories.parquet"),
    lambda out: (out / "study.trajectories.parquet").unlink(),
    lambda out: shortened(out / "study.trajectories.parquet"),
    lambda out: flipped(out / "study.trajectories.parquet"), lambda out: flipped(out / "study.parquet")],
    ids=["a number", "a number of the trajectories", "deleted trajectories", "truncated trajectories",
         "a bit of the trajectories", "a bit of the samples"])
def test_a_study_that_was_done_before_is_looked_at(damage: Damage, here: Here, fastest_fmus: Path,
                                                   tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, keep=["plant.v.position"])
    whole = here.study(study, tmp_path / "out")
    assert here.study(study, tmp_path / "out", resume=True) == whole
    assert here.simulated == 0 and here.said == []
    damage(tmp_path / "out")
    assert here.study(study, tmp_path / "out", resume=True) == whole
    assert here.simulated == 20 and "all samples are run again" in here.said[0]


NO_FILES: dict[str, Callable[[Path], Any]] = {
    "a pipe": os.mkfifo, "a folder": Path.mkdir, "a link": lambda path: path.symlink_to("/dev/zero"),
    "a socket": lambda path: socket.socket(socket.AF_UNIX).bind(str(path))}


@pytest.mark.parametrize("kind", NO_FILES)
@pytest.mark.parametrize("place", ["study.json", "samples-0000003.parquet", "what.ever", ".study.parts.lock"])
def test_names_and_ignores_entries_that_are_not_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str,
                                                      place: str) -> None:
    """Nobody waits for a pipe, and nothing is written to where a link leads."""
    monkeypatch.chdir(tmp_path)   # the path of a socket has a largest length
    parts = Parts(Path("study.parts"), "key")
    parts.begin()
    path = Path(place) if place.startswith(".") else parts.folder / place
    if place.startswith("samples"):
        parts.write(place, b"content")
        path = parts.files[place]
    path.unlink(missing_ok=True)
    NO_FILES[kind](path)
    with raises(ScenarioError, path, kind), parts.alone():
        Parts(Path("study.parts"), "key").find()
    if place.startswith("samples"):
        for used in (lambda: parts.write(place, b"content"), lambda: parts.read(place)):
            with raises(ScenarioError, path, kind):
                used()
    assert os.path.lexists(path)


def test_removes_unfinished_files_of_a_process(tmp_path: Path) -> None:
    """Killed between the making of a folder for what is unfinished and the end of it."""
    parts = Parts(tmp_path / "it.parts", "key")
    parts.begin()
    parts.write("samples-0000000.parquet", b"content")
    left = Path(tempfile.mkdtemp(prefix="maglev_scratch_", dir=parts.folder))
    (left / "samples-0000001.parquet").write_bytes(b"half")
    again = Parts(parts.folder, "key")
    assert again.find() == 0 and list(again.files) == ["samples-0000000.parquet"]
    assert not left.exists()


def test_a_file_in_place_of_the_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "study.parts").touch()
    with raises(ScenarioError, tmp_path / "study.parts", "file", "folder"):
        Parts(tmp_path / "study.parts", "key").find()
