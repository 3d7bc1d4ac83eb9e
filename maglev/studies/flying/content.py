"""What the samples of a study are run with: the code of this package, and files, by their content."""

import hashlib
from collections.abc import Mapping
from importlib.metadata import version

from maglev.cosim.step_loop import LIBRARY
from maglev.experiment.preparation import Experiment
from maglev.packages.installed import code


def code_of_package() -> str:
    """Version of this package and SHA-256 of its modules: two of one version may differ before a release."""
    return f"{version('maglev-fmus')} ({code()[:12]})"


def files_of(experiment: Experiment) -> dict[str, bytes]:
    """FMUs of an experiment, and the library that steps them, by their paths on a worker."""
    paths = {f"{name}/{path.name}": path for name, path in experiment.files.items()}
    paths |= {} if experiment.loop is None else {LIBRARY: experiment.loop.path}
    return {place: path.read_bytes() for place, path in paths.items()}


def digest(files: Mapping[str, bytes]) -> str:
    hashed = hashlib.sha256()
    for name, content in sorted(files.items()):
        hashed.update(f"{name}\0{len(content)}\0".encode())
        hashed.update(content)
    return hashed.hexdigest()
