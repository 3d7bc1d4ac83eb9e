"""A repository to begin with, whose CI notices a controller that changed."""

import shutil
import tempfile
from pathlib import Path

from maglev.api.checking import update
from maglev.descriptions import EXAMPLE
from maglev.descriptions.registry import known_stages
from maglev.descriptions.writer import render
from maglev.files.errors import BaselineError, StageError
from maglev.files.packages import HERE
from maglev.files.side_by_side import Say, Watch
from maglev.user.adoption import stage_named
from maglev.user.new_controller import new_controller
from maglev.user.new_stage import scenario_text, write_new

EXPERIMENT = "experiment.toml"
FILES = {"README.md": "README.md", "gitignore": ".gitignore", "gitlab-ci.yml": ".gitlab-ci.yml",
         "maglev.yml": ".github/workflows/maglev.yml", "wheels.md": "wheels/README.md"}   # by template


def new_repository(path: str | Path, stage: str | Path = EXAMPLE, *, watch: Watch | None = None,
                   say: Say | None = None) -> Path:
    """Write a folder for version control: controller, experiment, baseline, and the CI files of GitHub and GitLab.

    The experiment is run once, for its baseline. After an error nothing is left. Returns the folder.

    Parameters
    ----------
    path : path
        The folder; it must not be there.
    stage : str or path
        Name of a stage, or the description of your own, NAME.toml, which is copied.
    watch, say
        See `update`.

    Raises
    ------
    MaglevError
        If the folder is there already or cannot be made, there is no such stage, or the experiment cannot be run.

    Examples
    --------
    >>> import maglev
    >>> print(*sorted(file.name for file in maglev.new_repository("levitate", stage="2dof").iterdir()))
    .github .gitignore .gitlab-ci.yml README.md baselines controller.py experiment.toml wheels
    """
    folder = Path(path)
    if folder.exists():
        raise StageError(f"{folder}: already exists, expected the name of a new folder")
    if not folder.parent.is_dir():
        raise StageError(f"{folder}: the folder {folder.parent} does not exist")
    description = stage_named(str(stage))
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}-") as scratch:
        made = Path(scratch) / folder.name
        for file in FILES.values():
            (made / file).parent.mkdir(parents=True, exist_ok=True)
        own = Path(stage).name if description.name in known_stages().own else None
        if own is not None:
            shutil.copyfile(stage, made / own)
        new_controller(made / "controller.py", description.name if own is None else str(made / own))
        write_new(made / EXPERIMENT,
                  scenario_text(description, made / EXPERIMENT, own, more=True, controller="controller.py"))
        for template, name in FILES.items():
            write_new(made / name, render(f"new/repository/{template}.j2", description, name=folder.name,
                                         clone=str(HERE) if (HERE / "pyproject.toml").is_file() else ""))
        result, = update(made / EXPERIMENT, baselines=made / "baselines", watch=watch, say=say)
        if result.status == "error":
            raise BaselineError(f"{folder / EXPERIMENT}: {result.message}")
        made.rename(folder)
    return folder
