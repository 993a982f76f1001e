"""Image objects of other packages, recognised by their attributes: none of these packages is imported here."""

import sys
from typing import Any, NamedTuple, Optional, Tuple

import numpy as np

from ._errors import InvalidValue


NIBABEL = ("dataobj", "affine")
ITK = ("GetSpacing", "GetOrigin", "GetDirection")
XARRAY = ("dims", "coords", "data")
"""Attributes by which objects are recognised."""


class Image(NamedTuple):
    """An image: voxels (z, y, x) and their grid in the world."""

    array: np.ndarray
    """Voxels (z, y, x): a view if the object allows it."""
    affine: Any
    """World vectors between neighbouring voxels along x, y, z, and the position of voxel (0, 0, 0): four of (x, y, z)."""
    order: Tuple[int, int, int]
    """The indices of the x, y and z axes among the object's axes."""


def recognised(data) -> Optional[Image]:
    """The image of an image object; None for plain arrays."""
    if all(hasattr(data, name) for name in NIBABEL):
        return _nibabel(data)
    if all(hasattr(data, name) for name in ITK):
        return _itk(data)
    if all(hasattr(data, name) for name in XARRAY):
        return _xarray(data)
    return None


def is_image(data) -> bool:
    """Whether data is an image object."""
    return any(all(hasattr(data, name) for name in names) for names in (NIBABEL, ITK, XARRAY))


def channel_dimension(data) -> Optional[str]:
    """The dimension of channels of an xarray with three others; None without one, and for other data."""
    if not all(hasattr(data, name) for name in XARRAY) or len(data.dims) != 4:
        return None
    return next((str(name) for name in data.dims if str(name).lower() in ("c", "channel")), None)


def _nibabel(image) -> Image:
    """A spatial image of nibabel: axes (x, y, z), and an affine that may rotate and mirror."""
    array = np.asanyarray(image.dataobj)
    # NIfTI has up to seven axes. Drop trailing axes of length 1.
    while array.ndim > 3 and array.shape[-1] == 1:
        array = array[..., 0]
    if array.ndim != 3:
        raise InvalidValue(f"the image has {array.ndim} axes, {array.shape}: give one volume, image.slicer[..., 0] for instance")
    affine = np.eye(4) if image.affine is None else np.asarray(image.affine, dtype=float)
    return Image(array.transpose(2, 1, 0), affine[:3].T, (0, 1, 2))


def _itk(image) -> Image:
    """An image of SimpleITK or ITK: its arrays are (z, y, x), its metadata (x, y, z)."""
    package = sys.modules[type(image).__module__.split(".")[0]]
    as_array = getattr(package, "GetArrayViewFromImage", None) or getattr(package, "array_view_from_image", None)
    array = np.asarray(image) if as_array is None else as_array(image)
    if array.ndim != 3:
        raise InvalidValue(f"the image has {array.ndim} axes, {array.shape}: give a scalar image of three axes")
    spacing, origin = np.asarray(image.GetSpacing(), dtype=float), np.asarray(image.GetOrigin(), dtype=float)
    direction = np.asarray(image.GetDirection(), dtype=float).reshape(3, 3)
    return Image(array, np.vstack([(direction * spacing).T, origin]), (0, 1, 2))


def _xarray(array) -> Image:
    """A DataArray of xarray: dimensions x, y and z in any order, or three of other names in the order z, y, x."""
    dims = [str(name) for name in array.dims]
    if len(dims) != 3:
        raise InvalidValue(f"the array has {len(dims)} axes, {dims}: select three of them")
    names = [name.lower() for name in dims]
    order = (names.index("x"), names.index("y"), names.index("z")) if set(names) == set("xyz") else (2, 1, 0)
    steps = [_steps(array, dims[axis]) for axis in order]
    vectors = np.diag([step for _, step in steps])
    voxels = np.asanyarray(array.data).transpose(order[::-1])
    return Image(voxels, np.vstack([vectors, [first for first, _ in steps]]), order)


def _steps(array, name) -> Tuple[float, float]:
    """The first coordinate along an axis, and the step to the next."""
    if name not in array.coords:
        return 0.0, 1.0
    values = np.asarray(array.coords[name].values)
    if values.ndim != 1 or values.dtype.kind not in "iuf":
        return 0.0, 1.0
    values = values.astype(float)
    if len(values) == 1:
        return float(values[0]), 1.0
    step = (values[-1] - values[0]) / (len(values) - 1)
    # The tolerance is for coordinates stored as float32.
    if not np.allclose(np.diff(values), step, rtol=1e-3, atol=0.0):
        raise InvalidValue(f"the coordinates of {name} are not evenly spaced: only regular grids can be rendered, resample it")
    return float(values[0]), float(step)
