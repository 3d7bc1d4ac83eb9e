"""FMUs for the tests, built once, and the quick tests, which need none: `pytest -m quick`."""

import gc
import os
import shutil
import signal
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from pathlib import Path

import pytest
import wheel
from hypothesis import settings
from native_builds import KeptLibraries, built_once, missing_native_tools, require_native_tools

from maglev.cosim.fmu import Fmu, read_description
from maglev.descriptions.own_fmus import DEFINITIONS
from maglev.descriptions.registry import known_stages
from maglev.files.session import SESSION
from maglev.files.side_by_side import Workers
from maglev.fmi.compiler import Libraries
from maglev.scenario.catalogue import HOST, WASM, build
from maglev.user.source import FmuFile

NAMES = tuple(DEFINITIONS)
# Files that take longest, longest first: one that comes last keeps one processor busy, and the others wait. The first
# builds the native FMUs, which those after it do not ask for at once.
LONGEST = ("analysis/test_region.py", "pages/test_every_page.py", "language/test_random_programs.py",
           "many/test_other_process.py", "cosim/test_lane_loop.py", "many/test_search.py",
           "docs/test_printed_commands.py", "cli/test_signals.py", "api/test_batch.py", "user/test_misbehaviour.py",
           "runs/test_fmu_experiments_check.py", "many/test_written.py", "identification/test_accuracy.py",
           "controller_fmu/test_convergence.py", "tests/test_wheel.py", "docs/test_site.py",
           "cosim/test_foreign_masters.py", "examples/test_worked_examples.py", "pages/test_index.py")

SIMULATED_LIVE = tuple(name for name in NAMES if name.startswith(("Plant", "PID", "Regulator", "Linear", "Scheduled",
                                                                "Interpolated", "Adaptive", "Measurement")))

CHROMIUMS = ("chromium", "chromium-browser", "google-chrome")

# No deadline: a loaded machine is no failure. In CI always the same examples, so that a failure is the change's.
settings.register_profile("anywhere", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.register_profile("quick", deadline=None, max_examples=15)   # after every change; `make test` looks longer
settings.load_profile("ci" if os.environ.get("CI") else "anywhere")


@pytest.fixture(scope="session", autouse=True)
def workers() -> Workers:
    """One process for runs, samples and checks where a test does not say how many: each takes a second to start.

    Processes that have done the tasks of one command of a file do those of the next.
    """
    return SESSION.use(Workers(1, stay=True))


@pytest.fixture(scope="module", autouse=True)
def alone(workers: Workers) -> Iterator[None]:
    """No stages and processes of one file are left to the files after it, in whatever order they come."""
    yield
    known_stages().forget(*known_stages().own)
    workers.close()


@pytest.fixture(scope="session", autouse=True)
def interruptible() -> Iterator[None]:
    """Ctrl-C and the end of a terminal as at a terminal, here and in commands that tests start.

    A shell lets its background jobs ignore the one, `nohup` the other.
    """
    before = {number: signal.signal(number, handler) for number, handler in
              ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL))}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--fmus", type=Path, metavar="FOLDER", help="build the FMUs of the tests into the folders "
                     "python and native of FOLDER and leave them there, for what comes after the tests")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "quick: does not ask for the fixture slow (set by conftest.py)")
    config.addinivalue_line("markers", "thorough: takes long and looks at what seldom changes; `make thorough`")
    config.addinivalue_line("markers", "few(number): of its cases all but so many, spread over them, are thorough")
    if config.option.markexpr == "quick":
        settings.load_profile("quick")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Thousands of tests are made, and stay: the garbage collector need not go over them, neither now nor later."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark as quick what does not ask for `slow`, not even through another fixture; quick files go last."""
    leave_to_thorough(items)
    slow_files = set()
    for item in items:
        if "slow" in getattr(item, "fixturenames", ()):
            slow_files.add(item.path)
        elif item.get_closest_marker("thorough") is None:
            item.add_marker("quick")

    def place(item: pytest.Item) -> int:
        last = 2 * len(LONGEST) if item.path not in slow_files else len(LONGEST)
        return next((k for k, name in enumerate(LONGEST) if item.path.as_posix().endswith(f"/{name}")), last)

    items.sort(key=place)


def leave_to_thorough(items: list[pytest.Item]) -> None:
    """Mark as thorough the cases of tests beyond the few that are to be run with every change."""
    cases: dict[tuple[str, int], list[pytest.Item]] = {}
    for item in items:
        few = item.get_closest_marker("few")
        if few is not None and item.get_closest_marker("thorough") is None:
            cases.setdefault((item.nodeid.partition("[")[0], *few.args), []).append(item)
    for (_, number), same in cases.items():
        kept = {k * len(same) // number for k in range(number)}
        for k, item in enumerate(same):
            if k not in kept:
                item.add_marker("thorough")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Count what was skipped by what it wants, a package or a program."""
    wanted = Counter(str(report.longrepr[2]).removeprefix("Skipped: ")
                     for report in terminalreporter.stats.get("skipped", []) if isinstance(report.longrepr, tuple))
    if wanted:
        terminalreporter.section("left out")
        for reason, number in wanted.most_common():
            terminalreporter.write_line(f"{number} {'test' if number == 1 else 'tests'}: {reason}")


@pytest.fixture(scope="session")
def slow(request: pytest.FixtureRequest) -> None:
    """For what builds or runs FMUs, compiles, starts a browser, or runs for long: it is not in `pytest -m quick`.

    Fixtures of the kind ask for it; tests that do so by themselves say `@pytest.mark.usefixtures("slow")`.
    """
    if request.config.option.markexpr == "quick":
        pytest.fail("this test is marked as quick and asks for FMUs as it runs, expected \"slow\" among its fixtures")


@pytest.fixture(scope="session")
def fmus(slow: None, request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with every FMU."""
    asked: Path | None = request.config.option.fmus
    return built_once(tmp_path_factory, "fmus", lambda folder: build(NAMES, folder), asked and asked / "python")


@pytest.fixture(scope="session", autouse=True)
def own_cache(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """What is kept for this user is kept for these tests: blocks as C, the loop that steps FMUs.

    With --fmus it lies there, and the next session makes what has changed since.
    """
    asked: Path | None = request.config.option.fmus
    folder = built_once(tmp_path_factory, "cache", lambda _: None, asked and asked / "cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MAGLEV_CACHE", str(folder))
        yield folder


@pytest.fixture(scope="session", autouse=True)
def made_once(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Each native FMU becomes a library once; builds in other processes make all of theirs.

    With --fmus what they were made of lies there, and the next session makes what has changed since.
    """
    asked: Path | None = request.config.option.fmus
    folder = built_once(tmp_path_factory, "compiled", lambda _: None, asked and asked / "compiled")
    SESSION.use(KeptLibraries(folder), Libraries)


@pytest.fixture(scope="session")
def native_fmus(slow: None, request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with every FMU as C, for this machine alone."""
    require_native_tools()
    asked: Path | None = request.config.option.fmus
    return built_once(tmp_path_factory, "native_fmus", lambda folder: build(NAMES, folder, HOST),
                      asked and asked / "native")


@pytest.fixture(scope="session")
def fmi3_fmus(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a stage and its controllers as FMI 3.0, for this machine alone: the shell is the same in all FMUs."""
    require_native_tools()
    return built_once(tmp_path_factory, "fmi3_fmus", lambda folder: build(
        ["Plant3DOF", "Regulator3DOF", "Estimator3DOF"], folder, HOST._replace(fmi=3)))


@pytest.fixture(scope="session")
def clocked_fmus(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a stage and its regulator, which has a clock, as FMI 3.0."""
    require_native_tools()
    return built_once(tmp_path_factory, "clocked_fmus", lambda folder: build(
        ["Plant3DOF", "Regulator3DOF"], folder, HOST._replace(fmi=3, clocked=True)))


@pytest.fixture(scope="session")
def wasm_fmus(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with plants and controllers as WebAssembly modules."""
    require_native_tools()
    return built_once(tmp_path_factory, "wasm_fmus", lambda folder: build(SIMULATED_LIVE, folder, WASM))


@pytest.fixture(scope="session")
def fastest_fmus(slow: None, request: pytest.FixtureRequest) -> Path:
    """Folder with every FMU: native ones where they can be built, for what takes long; both kinds agree bit for bit."""
    folder: Path = request.getfixturevalue("fmus" if missing_native_tools() else "native_fmus")
    return folder


@pytest.fixture(scope="session")
def installed(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the wheel, the sources that it was built from, and an environment with it."""
    if os.name != "posix":
        pytest.skip("the folders of the environment are those of Linux and macOS")
    return built_once(tmp_path_factory, "wheel", wheel.install)


Load = Callable[[str], Fmu]


def loader(folder: Path) -> Iterator[Load]:
    """Function that instantiates an FMU of a folder by its name; instances are freed after the test."""
    fmus: list[Fmu] = []

    def instantiate(name: str) -> Fmu:
        path = folder / f"{name}.fmu"
        fmus.append(Fmu(name, FmuFile(path), read_description(name, path)))
        return fmus[-1]

    yield instantiate
    for fmu in fmus:
        fmu.close()


@pytest.fixture
def load(fmus: Path) -> Iterator[Load]:
    """Function that instantiates an FMU by its name."""
    yield from loader(fmus)


@pytest.fixture
def load_fastest(fastest_fmus: Path) -> Iterator[Load]:
    """The same for an FMU of the fastest kind that there is."""
    yield from loader(fastest_fmus)


@pytest.fixture
def load_native(native_fmus: Path) -> Iterator[Load]:
    """The same for a native FMU."""
    yield from loader(native_fmus)


@pytest.fixture(params=["load", "load_native"], ids=["python", "native"])
def load_either(slow: None, request: pytest.FixtureRequest) -> Load:
    """The same, once for each kind of FMU."""
    function: Load = request.getfixturevalue(request.param)
    return function


@pytest.fixture(params=["native_fmus", "fmus"], ids=["native", "python"])
def either_kind(slow: None, request: pytest.FixtureRequest) -> Path:
    """Folder with every FMU, once for each kind."""
    folder: Path = request.getfixturevalue(request.param)
    return folder


@pytest.fixture(scope="module")
def browser(slow: None) -> Iterator[object]:
    """A Chromium."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = next(filter(None, [os.environ.get("CHROMIUM"), *map(shutil.which, CHROMIUMS)]), None)
    if path is None:
        pytest.skip(f"no Chromium: none of {', '.join(CHROMIUMS)} is on the PATH, and CHROMIUM is not set")
    with api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield chromium
        chromium.close()
