"""Volume rendering of arrays, and of buffers on any OpenCL device, a plain CPU included.

High level: :func:`volshow` shows a volume in a notebook, :func:`render` returns its picture as an array. Low level: a :class:`Renderer`,
optionally on the caller's context and queue, with a :class:`Volume` or :class:`DeviceVolume`, :class:`Settings`, a :class:`Camera` and a
:class:`TransferFunction`.

Arrays and ``spacing`` are in the order (z, y, x). World coordinates (cameras, planes, lights) are (x, y, z).
"""

import atexit

from ._channels import channels
from ._errors import (
    Cancelled,
    DataWarning,
    DeviceError,
    Error,
    FileError,
    FileNotFound,
    InternalError,
    InvalidFile,
    InvalidType,
    InvalidValue,
    OutOfMemory,
    PermissionDenied,
    TimedOut,
)
from ._layersplat import (
    Camera,
    Channel,
    Colors,
    Device,
    DeviceVolume,
    Event,
    Framing,
    Labels,
    Renderer,
    Settings,
    Slice,
    Surface,
    TransferFunction,
    Volume,
    VolumeSequence,
    __version__,
    wait_for_interrupted_calls,
)
from ._show import View, render, volshow
from ._surfaces import Mesh, Spheres, Tubes
from ._transfer import transfer_function

atexit.register(wait_for_interrupted_calls)

__all__ = [
    "Camera",
    "Cancelled",
    "Channel",
    "Colors",
    "DataWarning",
    "Device",
    "DeviceError",
    "DeviceVolume",
    "Error",
    "Event",
    "FileError",
    "FileNotFound",
    "Framing",
    "InternalError",
    "InvalidFile",
    "InvalidType",
    "InvalidValue",
    "Labels",
    "Mesh",
    "OutOfMemory",
    "PermissionDenied",
    "Renderer",
    "Settings",
    "Slice",
    "Spheres",
    "Surface",
    "TimedOut",
    "TransferFunction",
    "Tubes",
    "View",
    "Volume",
    "VolumeSequence",
    "channels",
    "render",
    "transfer_function",
    "volshow",
]
