"""Conversion of colours and labels for the native module."""

import os

import numpy as np

from . import _arrays, _images
from ._checks import accepting
from ._errors import InvalidType, InvalidValue
from ._layersplat import Volume
from ._transfer import _color

LARGEST_ID = 2**32 - 1
KEYS = ("name", "color", "opacity", "visible")


def components(data, spacing):
    """The components of colours, the channels of an xarray or the last axis of an array, as volumes (z, y, x)."""
    arrays = _components(data, "an array (z, y, x, 3) or (z, y, x, 4) of red, green, blue and possibly alpha", "colours")
    if len(arrays) not in (3, 4):
        raise InvalidValue(f"the colours have {len(arrays)} components: give 3, red, green, blue, or 4 with alpha")
    kind, size = arrays[0].dtype.kind, arrays[0].dtype.itemsize
    if kind == "f":
        arrays = [one.astype(np.float32) for one in arrays]
    elif kind != "u" or size > 2:
        raise InvalidValue(f"colours cannot be of type {arrays[0].dtype}: give uint8, uint16, or floats from 0 to 1")
    names = ("red", "green", "blue", "alpha")
    return [Volume(one, spacing, name=name) for one, name in zip(arrays, names)]


def vectors(data, spacing):
    """The components x, y and z of vectors, the channels of an xarray or the last axis of an array, as volumes (z, y, x)."""
    arrays = _components(data, "an array (z, y, x, 3) of vectors", "vectors")
    if len(arrays) != 3:
        raise InvalidValue(f"the vectors have {len(arrays)} components: give 3, x, y and z")
    return [Volume(one, spacing, name="vectors") for one in arrays]


def _components(data, expected, what):
    """The channels of an xarray or the last axis of an array."""
    axis = _images.channel_dimension(data)
    if axis is not None:
        return [data.isel({axis: n}) for n in range(data.sizes[axis])]
    with accepting("data", data, expected):
        array = np.asanyarray(data)
    if array.ndim != 4:
        raise InvalidValue(f"the {what} have {array.ndim} axes: give four, z, y, x, component")
    return [array[..., n] for n in range(array.shape[3])]


def ids(data, spacing):
    """Ids of voxels (z, y, x), contiguous and in native byte order, and the affine, see ``_arrays.placed``."""
    voxels, affine, _ = _arrays.placed(data, spacing)
    return np.require(voxels, voxels.dtype.newbyteorder("="), "CA"), affine


def table(given):
    """The argument ``table`` of labels: None, a path, or entries (id, name, colour, opacity, visible)."""
    if given is None:
        return None
    if isinstance(given, str) or hasattr(given, "__fspath__"):
        return os.fspath(given)
    if not hasattr(given, "items"):
        raise InvalidType(f"table is of type {type(given).__name__}: give a dict from ids to names or colours, or a file")
    return [_entry(number, look) for number, look in given.items()]


def _entry(number, look):
    with accepting("table", number, "whole numbers as ids"):
        number = int(number) if int(number) == number else -1
    if not 0 < number <= LARGEST_ID:
        raise InvalidValue(f"table has an id that is not a whole number from 1 to {LARGEST_ID}; 0 is the background")
    if isinstance(look, str):
        look = {"color" if look.startswith("#") else "name": look}
    elif not hasattr(look, "items"):
        look = {"color": look}
    unknown = [key for key in look if key not in KEYS]
    if unknown:
        raise InvalidValue(f"table has the key {unknown[0]!r} for label {number}: use {', '.join(KEYS)}")
    color, opacity = look.get("color"), look.get("opacity")
    if color is not None:
        if not isinstance(color, str) and len(color) == 4:
            opacity = color[3] if opacity is None else opacity
        color = _color(color)
    with accepting("table", opacity, "opacities from 0 to 1"):
        opacity = 1.0 if opacity is None else float(opacity)
    name = look.get("name")
    return number, None if name is None else str(name), color, opacity, bool(look.get("visible", True))
