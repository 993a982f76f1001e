"""The device of those who name none."""

import functools
import os

from . import _layersplat


@functools.lru_cache(maxsize=None)
def device() -> "_layersplat.Device":
    """The device that ``LAYERSPLAT_DEVICE`` names, or a GPU if there is one, or the CPU. It is opened once and kept, with its kernels."""
    return _layersplat.Device(os.environ.get("LAYERSPLAT_DEVICE") or None)
