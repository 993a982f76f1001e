"""Exceptions: each is a layersplat.Error, and the built-in one that is usual for its kind."""

import concurrent.futures
from typing import Tuple


class Error(Exception):
    """Everything that layersplat raises. ``fields`` names the arguments at fault, where they are known."""

    fields: Tuple[str, ...] = ()


class DataWarning(UserWarning):
    """Voxels that are not shown as they are: without a value, or too many for 32-bit floats to tell apart; and what a file has that is
    not used."""


class InvalidValue(Error, ValueError):
    """An argument out of range, or in conflict with another one or with the view."""


class InvalidType(Error, TypeError):
    """An argument of a wrong type."""


class DeviceError(Error, RuntimeError):
    """No OpenCL, or an OpenCL call or a command that failed."""


class OutOfMemory(Error, MemoryError):
    """Too little memory, on the host or on the device."""


class TimedOut(Error, TimeoutError):
    """A frame that took longer than its time limit."""


class Cancelled(Error, concurrent.futures.CancelledError):
    """A frame that another thread cancelled: ``Renderer.cancel``."""


class InternalError(Error, RuntimeError):
    """A defect of layersplat: the native part panicked. A renderer cannot be used afterwards."""


class FileError(Error, OSError):
    """A file that cannot be read or written: ``filename``, and the system's ``errno`` where it gave one."""

    def __str__(self) -> str:
        # OSError would write errno and the file's name before the message, which has them.
        return str(self.args[0]) if self.args else ""


class FileNotFound(FileError, FileNotFoundError):
    """A file that does not exist."""


class PermissionDenied(FileError, PermissionError):
    """A file that this user cannot read or write."""


class InvalidFile(FileError, InvalidValue):
    """A file with contents that are damaged, or not as described: an OSError and a ValueError."""
