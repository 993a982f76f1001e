"""Conversion of arrays for the native module: three axes, z, y, x, of a voxel type, with any strides and byte order.

The native module reads voxels with the GIL released and requires immutable memory, since another thread could write to it. Every array
that could be written to is therefore copied. If another thread writes during numpy's copy, the copy holds a mix of old and new voxels.
"""

import mmap

import numpy as np

from . import _images, _layersplat
from ._checks import accepting
from ._errors import InvalidValue, OutOfMemory


def placed(data, spacing):
    """Voxels and grid of ``Volume(data, spacing)``: an array (z, y, x); the world vectors between neighbouring voxels along x, y and z,
    followed by the world position of voxel (0, 0, 0); and the number of masked voxels.

    ``spacing`` is in the order of the data's axes and overrides the spacing of an image object.
    """
    image = _images.recognised(data)
    if image is None:
        array, affine = _plain(data), axes(spacing)
    else:
        array, affine = image.array, np.array(image.affine, dtype=float)
        if spacing is not None:
            affine = _respaced(affine, _three(spacing)[list(image.order)])
    try:
        voxels = _unchanging(_voxels(array), data)
    except MemoryError as error:
        size = "x".join(map(str, array.shape))
        raise OutOfMemory(f"the voxels must be copied, {size} of {array.dtype}: {error}; see Volume for memory that is not copied") from error
    masked = int(np.ma.count_masked(data)) if isinstance(data, np.ma.MaskedArray) else 0
    return voxels, [[float(x) for x in vector] for vector in affine], masked


def axes(spacing):
    """Vectors of an axis-aligned grid at the origin. ``spacing`` is one number or (z, y, x)."""
    z, y, x = (1.0, 1.0, 1.0) if spacing is None else _three(spacing)
    return [[float(x), 0.0, 0.0], [0.0, float(y), 0.0], [0.0, 0.0, float(z)], [0.0, 0.0, 0.0]]


def on_device(device, array):
    """A volume of a ``pyopencl.array.Array`` (z, y, x), in place."""
    shape, strides, dtype = array.shape, array.strides, np.dtype(array.dtype)
    if len(shape) != 3:
        raise InvalidValue(f"the array has {len(shape)} axes: give three, z, y, x")
    if strides[2] != dtype.itemsize and shape[2] > 1:
        raise InvalidValue("the array's last axis must be contiguous on the device: copy it first")
    return _layersplat.DeviceVolume(
        device, array.base_data, shape, dtype, first=array.offset, pitches=(strides[1], strides[0]), wait_for=array.events
    )


class _Held(np.ndarray):
    """A view that also holds a memoryview, which keeps a mapped file from being closed."""

    memory = None


def _unchanging(voxels, data):
    """The voxels in immutable memory: in place if their memory is immutable, otherwise a copy."""
    if isinstance(data, np.ndarray) and not np.may_share_memory(voxels, data):
        # Already a copy, made by the conversion.
        return voxels
    memory = _read_only_memory(voxels)
    if memory is None:
        return voxels.copy(order="K")
    held = voxels.view(_Held)
    held.memory = memory
    return held


def _read_only_memory(array):
    """The memory of an array if it is immutable: bytes, or a file mapped read-only. Otherwise None.

    The array's flag is not sufficient: its base may be writable, and flags can be set again.
    """
    while isinstance(array, np.ndarray):
        array = array.base
    owner = array.obj if isinstance(array, memoryview) else array
    if isinstance(owner, (bytes, mmap.mmap)):
        memory = memoryview(owner)
        return memory if memory.readonly else None
    return None


def _plain(data):
    with accepting("data", data, "an array (z, y, x), or an image of nibabel, SimpleITK, ITK or xarray"):
        array = np.asanyarray(data)
    if isinstance(array, np.ma.MaskedArray):
        # Masked voxels count as background, like NaN.
        wide = array.dtype.kind in "iu" and array.dtype.itemsize > 2 or array.dtype == np.float64
        array = array.astype(np.float64 if wide else np.float32).filled(np.nan)
    if array.ndim != 3:
        raise InvalidValue(f"the array has {array.ndim} axes: give three, z, y, x")
    return array


def _three(spacing):
    with accepting("spacing", spacing, "one number, or three in the order of the axes"):
        values = np.asarray(spacing, dtype=float)
    if values.shape not in [(), (3,)]:
        raise InvalidValue(f"spacing has the shape {values.shape}: give one number, or three in the order of the axes")
    return np.broadcast_to(values, 3)


def _respaced(affine, spacing):
    """The affine with the same directions and other spacings along x, y and z."""
    lengths = np.linalg.norm(affine[:3], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        affine[:3] *= (spacing / lengths)[:, None]
    return affine


def _voxels(array):
    """The array in a type of the native module: uint8, int8, uint16, int16 and float32 unchanged; others contiguous and aligned."""
    kind, size = array.dtype.kind, array.dtype.itemsize
    if kind == "b":
        return array.view(np.uint8)
    if (kind in "iu" and size <= 2) or (kind == "f" and size == 4):
        return array
    if kind == "f" and size == 2:
        return array.astype(np.float32)
    if kind in "iu" and size == 8:
        return np.require(array, _narrower(array), "CA")
    if kind in "iuf":
        return np.require(array, f"={kind}{min(size, 8)}", "CA")
    raise InvalidValue(f"voxels cannot be of type {array.dtype}: give integers or floats")


def _narrower(array):
    """A type that holds the integers of an array: of 32 bits if they fit."""
    if array.size == 0:
        return np.int32
    low, high = int(array.min()), int(array.max())
    for narrow in (np.int32, np.uint32):
        if np.iinfo(narrow).min <= low and high <= np.iinfo(narrow).max:
            return narrow
    return np.float64
