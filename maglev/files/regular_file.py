"""Files that can be opened without a wait: a reader of a named pipe or a terminal may wait for ever."""

import errno
import stat
from pathlib import Path

SPECIAL = {stat.S_ISFIFO: "a named pipe", stat.S_ISCHR: "a device", stat.S_ISBLK: "a device",
           stat.S_ISSOCK: "a socket"}


def regular(path: Path) -> Path:
    """Return the path; OSError, which names it, if it is a named pipe, a device or a socket.

    Any other error is left to the code that opens it.
    """
    try:
        mode = path.stat().st_mode
    except OSError:
        return path
    kind = next((name for is_special, name in SPECIAL.items() if is_special(mode)), None)
    if kind is not None:
        raise OSError(errno.EINVAL, f"is {kind}, expected a file", str(path))
    return path
