"""Exceptions: what the library refuses or cannot do, with its own words."""

from typing import Tuple


class Error(Exception):
    """Everything that layersplat raises of itself. ``fields`` names the arguments at fault, where they are known."""

    fields: Tuple[str, ...] = ()


class InvalidValue(Error, ValueError):
    """An argument that cannot be, or that contradicts another one or the view."""


class DeviceError(Error, RuntimeError):
    """No OpenCL, or something that it could not do; or a frame that took longer than it may."""


class OutOfMemory(Error, MemoryError):
    """More than the machine or the device has."""


class FileError(Error, OSError):
    """A file that cannot be read or written."""
