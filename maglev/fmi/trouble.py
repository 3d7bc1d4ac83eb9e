"""The place and reason of a failure in a user's class, in one line."""

import traceback
from pathlib import Path

RAISED = (Exception, SystemExit)   # end a step, but no process: a class that exits has not done its work

OWN = "own_"   # begins the names of the user's modules in an FMU: a model.py must not meet another model.c


def error_text(error: BaseException, written: type | None = None) -> str:
    """File, line, kind and text of an error: the innermost line of the files next to that of a class, if there is one.

    Without a class, or without such a line, the innermost line of all.
    """
    text = " ".join(str(error).split())
    what = f"{type(error).__name__}: {text}" if text else type(error).__name__
    if isinstance(error, SyntaxError) and error.filename:
        return f"{Path(error.filename).name}, line {error.lineno}: {type(error).__name__}: {error.msg}"
    frames = traceback.extract_tb(error.__traceback__)
    if not frames:
        return what
    code = getattr(getattr(written, "step", None), "__code__", None)
    folder = None if code is None else Path(code.co_filename).parent   # of the file that defines the class
    beside = [frame for frame in frames if Path(frame.filename).parent == folder]
    place = (beside or frames)[-1]
    return f"{Path(place.filename).name.removeprefix(OWN)}, line {place.lineno}: {what}"
