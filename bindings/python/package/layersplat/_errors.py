"""Exceptions. Each derives from layersplat.Error and from the built-in exception of its kind."""

import concurrent.futures
from typing import Tuple


class Error(Exception):
    """Base class of all exceptions of layersplat. ``fields`` names the invalid arguments, if they are known."""

    fields: Tuple[str, ...] = ()


class DataWarning(UserWarning):
    """Voxels that cannot be shown exactly: without a value, or integers that 32-bit floats cannot distinguish. Also for parts of a file
    that are ignored."""


class InvalidValue(Error, ValueError):
    """An argument that is out of range, or conflicts with another one or with the view."""


class InvalidType(Error, TypeError):
    """An argument of the wrong type."""


class DeviceError(Error, RuntimeError):
    """OpenCL is not available, or an OpenCL call or command failed."""


class OutOfMemory(Error, MemoryError):
    """Host or device memory is exhausted, or the memory budget is too small."""


class TimedOut(Error, TimeoutError):
    """A frame exceeded its time limit."""


class Cancelled(Error, concurrent.futures.CancelledError):
    """A frame was cancelled by another thread: ``Renderer.cancel``."""


class InternalError(Error, RuntimeError):
    """A defect of layersplat: the native module panicked. The renderer cannot be used afterwards."""


class FileError(Error, OSError):
    """A file cannot be read or written. ``filename`` names it; ``errno`` is the system's error number, if any."""

    def __str__(self) -> str:
        # OSError would prepend errno and the file name, which the message already contains.
        return str(self.args[0]) if self.args else ""


class FileNotFound(FileError, FileNotFoundError):
    """A file does not exist."""


class PermissionDenied(FileError, PermissionError):
    """The user lacks permission to read or write a file."""


class InvalidFile(FileError, InvalidValue):
    """A file is damaged or does not match its description: an OSError and a ValueError."""
