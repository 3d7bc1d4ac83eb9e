"""The stages of this project, by their names in the names of experiments."""

from collections.abc import Collection, Iterable

from maglev.descriptions.description_file import PACKAGED, Reader
from maglev.files.toml_file import read_toml
from pmlsm.stage_description import StageDescription

# A test checks that they fit together, so that commands start without this check.
PACKAGED_STAGES: dict[str, StageDescription] = {path.stem: Reader(path).read(StageDescription, read_toml(path), "")
                        for path in sorted(PACKAGED.glob("*.toml"))}
# what one with a user's motor begins with
SINGLE = next(name for name, stage in PACKAGED_STAGES.items() if len(stage.motors) == 1)


def best_stage(models: Iterable[str], axes: Collection[str]) -> StageDescription | None:
    """Stage of FMUs by their names, or otherwise the one that has most of the axes, air gap included; None if none.

    Of FMUs of several stages, such as a controller that knows of no tilt on a plant that tilts, it is the one with most
    of the axes: the plant's.
    """
    models = tuple(models)
    stages = [stage for stage in PACKAGED_STAGES.values() if any(model.endswith(stage.suffix) for model in models)]
    if stages:
        return max(stages, key=lambda stage: (len({*stage.axis_names} & {*axes}), len(stage.suffix)))
    stages = [stage for stage in PACKAGED_STAGES.values() if stage.vertical.name in axes]
    return max(stages, key=lambda stage: (len({*stage.axis_names} & {*axes}), -len(stage.axes)), default=None)
