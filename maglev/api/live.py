"""The live page: plants and controllers that fly in a browser."""

from pathlib import Path

from maglev.live.page import write_live_page


def write_live(out: str | Path = "results", *, fmus: str | Path = "fmus") -> Path:
    """Write `live.html`: one page that flies the stages in a browser, from disk and without network.

    Parameters
    ----------
    out : path
        Folder for the page, made if it is not there.
    fmus : path
        Folder of the FMUs, whose folder `wasm` has the WebAssembly modules.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    MaglevError
        If a module is missing: `build(native=True, target="wasm")` makes them.
    """
    return write_live_page(Path(out), Path(fmus) / "wasm")
