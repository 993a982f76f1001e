"""Which OpenCL loader and implementation the native module finds.

Released wheels contain an OpenCL loader, that of pyopencl's wheel (ocl-icd): `scripts/package wheel` puts it into `_opencl`. It is used on
systems without OpenCL, with the implementation of the PyPI package pocl-binary-distribution if that is installed. That implementation calls
the linker of a C compiler. Without one, it gets `_opencl/ld`, which calls the linker of the PyPI package ziglang.
"""

import ctypes
import importlib.util
import os
import pathlib
import shutil
from typing import Optional

HOME = "PYOPENCL_HOME"
LOADER = "OPENCL_DYLIB_PATH"
#: Variables that tell loaders where implementations are.
VENDORS = ("OCL_ICD_VENDORS", "OPENCL_VENDOR_PATH", "OCL_ICD_FILENAMES")
#: Where systems register implementations.
REGISTERED = pathlib.Path("/etc/OpenCL/vendors")
#: The wheel's own loader.
OWN = pathlib.Path(__file__).with_name("_opencl") / "libOpenCL.so.1"
#: What `_opencl/ld` calls.
ZIG = OWN.parents[2] / "ziglang" / "zig"


def prepare() -> None:
    """Sets the environment of the OpenCL loader. The native module calls this before it opens a loader.

    Without OpenCL on the system, ``OPENCL_DYLIB_PATH`` names the wheel's own loader, ``OCL_ICD_VENDORS`` an implementation that is installed
    as a Python package, and ``COMPILER_PATH`` the folder of its linker. Variables that are set are left alone. The loader of pyopencl's wheel also searches the folder
    ``PYOPENCL_HOME`` for implementations, and crashes if that is not set. Importing pyopencl sets it to the same folder.
    """
    if not os.environ.get(LOADER) and OWN.exists():
        _use_own_loader()
    if HOME in os.environ:
        return
    for path in os.environ.get(LOADER, "").split(";"):
        home = _home(pathlib.Path(path)) if path else None
        if home is not None:
            os.environ[HOME] = str(home)
            return


def _use_own_loader() -> None:
    """Uses the own loader if the system has none, or no implementation while there is an installed one."""
    implementation = None
    if not any(os.environ.get(name) for name in VENDORS) and not _has_implementation():
        implementation = _installed()
    if implementation is not None:
        os.environ["OCL_ICD_VENDORS"] = str(implementation)
        # With a compiler on the system, the variable would change what that does.
        if not _has_compiler():
            os.environ.setdefault("COMPILER_PATH", str(OWN.parent))
    if implementation is not None or not _can_load("libOpenCL.so.1"):
        os.environ[LOADER] = str(OWN)


def _has_implementation() -> bool:
    """Whether an implementation is registered on this system, and its library can be loaded."""
    return any(_can_load(library) for library in map(_library, REGISTERED.glob("*.icd")) if library)


def _library(file: pathlib.Path) -> str:
    """The library that a vendor file names; empty if it cannot be read."""
    try:
        return file.read_text(errors="replace").split("\n", 1)[0].strip()
    except OSError:
        return ""


def _can_load(library: str) -> bool:
    try:
        ctypes.CDLL(library)
        return True
    except OSError:
        return False


def _installed() -> Optional[pathlib.Path]:
    """The library of pocl-binary-distribution, which registers it for pyopencl; None if it or a linker is not installed."""
    spec = importlib.util.find_spec("pocl_binary_distribution")
    if spec is None or spec.origin is None or not (_has_compiler() or ZIG.exists()):
        return None
    folder = pathlib.Path(spec.origin).parents[1] / "pyopencl" / ".libs"
    libraries = [folder / _library(file) for file in sorted(folder.glob("*.icd"))]
    return next((library for library in libraries if library.is_file()), None)


def _has_compiler() -> bool:
    return shutil.which("cc") is not None and shutil.which("ld") is not None


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
