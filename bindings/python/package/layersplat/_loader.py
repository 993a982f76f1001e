"""Environment of an OpenCL loader that ``OPENCL_DYLIB_PATH`` names."""

import os
import pathlib
from typing import Optional

HOME = "PYOPENCL_HOME"


def prepare() -> None:
    """Sets ``PYOPENCL_HOME`` for the loader of pyopencl's wheel. The native module calls this before it opens a loader.

    That loader also searches this folder for OpenCL implementations, and crashes if the variable is not set. Importing pyopencl sets it
    to the same folder.
    """
    if HOME in os.environ:
        return
    for path in os.environ.get("OPENCL_DYLIB_PATH", "").split(";"):
        home = _home(pathlib.Path(path)) if path else None
        if home is not None:
            os.environ[HOME] = str(home)
            return


def _home(loader: pathlib.Path) -> Optional[pathlib.Path]:
    """The folder that the loader of pyopencl's wheel needs; None for other loaders."""
    try:
        if HOME.encode() not in loader.read_bytes():
            return None
    except OSError:
        # For example a name without a folder, which the system searches for.
        return None
    folder = loader.absolute().parent
    return {".libs": folder.parent, "pyopencl.libs": folder.with_name("pyopencl")}.get(folder.name, folder)
