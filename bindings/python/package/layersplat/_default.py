"""The default device."""

import functools
import os

from . import _layersplat


@functools.lru_cache(maxsize=None)
def device() -> "_layersplat.Device":
    """The device named by ``LAYERSPLAT_DEVICE``, otherwise the first GPU, otherwise the CPU. It is opened once and cached with its kernels."""
    return _layersplat.Device(os.environ.get("LAYERSPLAT_DEVICE") or None)
