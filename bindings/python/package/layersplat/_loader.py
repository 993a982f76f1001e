"""What an OpenCL loader needs that ``OPENCL_DYLIB_PATH`` names."""

import os
import pathlib
from typing import Optional

HOME = "PYOPENCL_HOME"


def prepare() -> None:
    """Sets ``PYOPENCL_HOME`` for the loader of pyopencl's wheel. The native part calls this before it opens a loader.

    That loader also looks for implementations in the folder of this name, and ends the process where it is not set. Importing pyopencl
    sets it, and so does this, to the same folder.
    """
    if HOME in os.environ:
        return
    for path in os.environ.get("OPENCL_DYLIB_PATH", "").split(";"):
        home = _home(pathlib.Path(path)) if path else None
        if home is not None:
            os.environ[HOME] = str(home)
            return


def _home(loader: pathlib.Path) -> Optional[pathlib.Path]:
    """The folder that a loader needs to be told; None of other loaders."""
    try:
        if HOME.encode() not in loader.read_bytes():
            return None
    except OSError:
        # A name without a folder, say, which the system looks for.
        return None
    folder = loader.absolute().parent
    return {".libs": folder.parent, "pyopencl.libs": folder.with_name("pyopencl")}.get(folder.name, folder)
