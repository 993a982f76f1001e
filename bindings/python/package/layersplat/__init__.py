"""Volume rendering of arrays, and of buffers on any OpenCL device, a plain CPU included.

Short: :func:`volshow` shows a volume in a notebook, :func:`render` makes an array of it. Long: a :class:`Renderer` on a context and a queue
of the caller's, with a :class:`DeviceVolume`, :class:`Settings`, a :class:`Camera` and a :class:`TransferFunction` of one's own.

Arrays are (z, y, x), and so is ``spacing``, in the order of the array's axes. Places in the world (cameras, planes, light) are (x, y, z).
"""

import atexit

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
    Device,
    DeviceVolume,
    Event,
    Framing,
    Renderer,
    Settings,
    TransferFunction,
    Volume,
    __version__,
    wait_for_interrupted_calls,
)
from ._show import View, render, volshow
from ._transfer import transfer_function

atexit.register(wait_for_interrupted_calls)

__all__ = [
    "Camera",
    "Cancelled",
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
    "OutOfMemory",
    "PermissionDenied",
    "Renderer",
    "Settings",
    "TimedOut",
    "TransferFunction",
    "View",
    "Volume",
    "render",
    "transfer_function",
    "volshow",
]
