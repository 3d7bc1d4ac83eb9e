"""Two commands at once, a full disk, a report that cannot be written: whole files, and messages that name them."""

import errno
import os
import subprocess
import sys
import threading
import zipfile
from pathlib import Path
from typing import Any

import pytest
from command_line import error_line, maglev
from facts import raises
from faulty_fmus import faulty, faulty_run

from maglev.cosim.master import RunFailed
from maglev.files.table import read_table
from maglev.files.whole_file import whole_file, whole_files, write_whole
from maglev.runs.execution import execute
from maglev.scenario.catalogue import build
from maglev.scenario.loading import load_plan

SHORT = '\nextends = "{base}"\nname = "short"\ntitle = "A short hold"\nstop_time = "{seconds} s"\n'


def full_disk(*_: Any, **__: Any) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


def test_two_runs_into_one_folder_leave_whole_files(fmus: Path, tmp_path: Path) -> None:
    """Of the same name and different length: every file is all of one of them, and who comes second is told."""
    base = load_plan("2dof-setpoints").source
    lengths = (1.0, 1.5)
    commands = []
    for seconds in lengths:
        scenario = tmp_path / f"of_{seconds}.toml"
        scenario.write_text(SHORT.format(base=base, seconds=seconds))
        commands.append([sys.executable, "-m", "maglev", "run", str(scenario), "--fmus", str(fmus), "--out",
                         str(tmp_path / "out")])
    both = [subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) for command in commands]
    said = [each.communicate(timeout=300)[1] for each in both]
    codes = [each.returncode for each in both]
    assert codes in ([0, 0], [0, 2], [2, 0]), said
    assert all(b"short: another process is writing the files of this run" in errors
               for code, errors in zip(codes, said, strict=True) if code)
    table = read_table(tmp_path / "out" / "short.csv")
    assert table.column("time")[-1] in lengths
    assert (len(table.column("time")) - 1) * 1e-3 == pytest.approx(table.column("time")[-1])
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["short.csv", "short.json", "short.txt"]


def test_a_full_disk_names_the_file(tmp_path: Path) -> None:
    path = tmp_path / "results.csv"
    path.write_text("before")
    with pytest.raises(OSError) as failure, whole_file(path):
        full_disk()
    assert failure.value.filename == str(path)
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]


def test_a_full_disk_does_not_hide_the_message_of_the_fmu(fmus: Path, tmp_path: Path,
                                                          monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("maglev.runs.results.csv.writer", full_disk)
    with raises(RunFailed, "0.1 s", "controller", "pd_controller.fmu", "fmi2DoStep", "status -1",
                tmp_path / "2dof-step-1-nonlinear.partial.csv", "No space left on device"):
        execute(faulty_run(faulty("negative", tmp_path), fmus), tmp_path)


@pytest.mark.usefixtures("slow")
def test_a_build_is_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The disk is full when the second FMU is written."""
    (tmp_path / "PID2DOF.fmu").write_text("before")
    write, calls = zipfile.ZipFile.writestr, []

    def written(self: zipfile.ZipFile, *arguments: Any, **more: Any) -> None:
        calls.append(self.filename)
        if len(set(calls)) == 2:
            full_disk()
        write(self, *arguments, **more)

    monkeypatch.setattr(zipfile.ZipFile, "writestr", written)
    result = maglev("build", "PID2DOF", "Plant2DOF", "--fmus", tmp_path)
    assert "No space left on device" in error_line(result)
    assert error_line(result).endswith(f"{tmp_path / 'Plant2DOF.fmu'}: No space left on device")
    assert [path.name for path in tmp_path.iterdir()] == ["PID2DOF.fmu"]
    assert (tmp_path / "PID2DOF.fmu").read_text() == "before"
    monkeypatch.undo()
    assert build(["PID2DOF"], tmp_path) == [tmp_path / "PID2DOF.fmu"]
    assert zipfile.is_zipfile(tmp_path / "PID2DOF.fmu")


def test_files_of_a_block_that_fails_do_not_appear(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), whole_files(tmp_path) as unfinished:
        write_whole(unfinished / "a", "text")
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_junit_that_cannot_be_written_hides_no_results(fmus: Path, tmp_path: Path) -> None:
    result = maglev("check", "2dof-smooth-nonlinear", "--fmus", fmus, "--junit", tmp_path)
    assert "2dof-smooth-nonlinear: passed" in result.stdout
    assert str(tmp_path) in error_line(result)


def test_junit_without_a_name_is_refused_before_anything_runs(tmp_path: Path) -> None:
    result = maglev("check", "2dof-smooth-nonlinear", "--fmus", tmp_path, "--junit", "")
    assert error_line(result) == "maglev: --junit: expected the name of a file, got '' or ."


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    """The file that it leads to is the new one; also where there is none yet."""
    (tmp_path / "elsewhere").mkdir()
    link, file = tmp_path / "check.xml", tmp_path / "elsewhere" / "of_mine.xml"
    link.symlink_to(file)
    for text in ("first", "second"):
        write_whole(link, text)
        assert link.is_symlink()
        assert file.read_text() == text
    assert {path.name for path in tmp_path.rglob("*")} == {"check.xml", "elsewhere", "of_mine.xml"}


def test_a_pipe_is_written_into(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    written = threading.Thread(target=write_whole, args=(pipe, "all of it"))
    written.start()
    assert pipe.read_text() == "all of it"
    written.join()
    assert pipe.is_fifo()
    assert list(tmp_path.iterdir()) == [pipe]


@pytest.mark.parametrize("file", [False, True])
def test_standard_output_as_a_file(tmp_path: Path, file: bool) -> None:
    """A pipe, or the file that a shell has opened for it: what was printed before stays."""
    (tmp_path / "printed").write_text("before\n")
    command = [sys.executable, "-c", "from maglev.files.whole_file import write_whole; from pathlib import Path; "
               "print('here', flush=True); write_whole(Path('/dev/fd/1'), 'text')"]
    with (tmp_path / "printed").open("a") as opened:
        done = subprocess.run(command, stdout=opened if file else subprocess.PIPE, text=True, check=True)
    printed = (tmp_path / "printed").read_text()
    assert (printed if file else printed + done.stdout) == "before\nhere\ntext"
