"""Transfer functions from cmap, clim and opacity, as in plotting packages."""

from typing import Any, Optional, Tuple

import numpy as np

from ._checks import accepting
from ._errors import InvalidValue
from ._layersplat import TransferFunction, Volume

SAMPLES = 256
"""Number of samples taken of a callable colour map."""
OPACITY = "a number, linear, (value, opacity) points or an array of opacities"


def transfer_function(
    volume: Volume, cmap: Any = None, clim: Optional[Tuple[float, float]] = None, opacity: Any = None
) -> TransferFunction:
    """A transfer function for a volume.

    cmap: a name of ``layersplat transfer --list``, such as ``grey``, ``viridis`` or ``inferno_r``; a file of ParaView or 3D Slicer; a
    TransferFunction; a list of evenly spaced colours, each (red, green, blue), 0 … 1, or ``#rrggbb``; or a callable that maps numbers
    0 … 1 to colours, such as a colour map of matplotlib (its alpha is ignored).
    clim: range (lowest, highest) to which the map is stretched. By default the range of the function or file, or else of the volume.
    opacity: a factor for all opacities; ``linear``, from 0 to 1 over clim; a list of (value, opacity); or an array of opacities, evenly
    spaced over clim. Opacities are per unit distance, see Settings. By default those of the map, or a slow rise.

    Without cmap and clim, and with no opacity or a factor, the function is made from the volume's histogram.
    """
    factor = _factor(opacity)
    if cmap is None and clim is None and (opacity is None or factor is not None):
        found = TransferFunction.automatic(volume)
    else:
        found = _colored(volume, "viridis" if cmap is None else cmap, clim)
    if opacity is None:
        return found
    if factor is not None:
        points = [(value, min(1.0, factor * a)) for value, a in found.opacities]
    else:
        points = _points(opacity, _limits(clim) or _own_limits(volume, cmap, found))
    return TransferFunction(found.colors, points, name=found.name)


def _colored(volume, cmap, clim) -> TransferFunction:
    """A transfer function with the colours of cmap and its opacities, or default ones."""
    limits = _limits(clim)
    if isinstance(cmap, TransferFunction):
        return cmap.stretched(*limits) if limits else cmap
    if isinstance(cmap, str) or hasattr(cmap, "__fspath__"):
        found = TransferFunction.open(cmap, volume)
        return found.stretched(*limits) if limits else found
    slow = TransferFunction.builtin("grey", volume)
    slow = slow.stretched(*limits) if limits else slow
    colors = _sampled(cmap) if callable(cmap) else _listed(cmap)
    values = np.linspace(*slow.range, len(colors)) if len(colors) > 1 else [slow.range[0]]
    return TransferFunction(list(zip(values, colors)), slow.opacities, name=str(getattr(cmap, "name", "colours")))


def _sampled(cmap):
    """Colours of a callable."""
    made = cmap(np.linspace(0.0, 1.0, SAMPLES))
    with accepting("what cmap returned", made, "an array of colours, red, green and blue"):
        rgba = np.asarray(made, dtype=float)
    if rgba.ndim != 2 or rgba.shape[0] != SAMPLES or rgba.shape[1] < 3:
        raise InvalidValue(f"cmap returned an array of shape {rgba.shape} for {SAMPLES} numbers: expected one colour each, red, green, blue")
    return [tuple(color) for color in np.clip(rgba[:, :3], 0.0, 1.0).tolist()]


def _listed(colors):
    """Colours from a list."""
    with accepting("cmap", colors, "a name, a file, a TransferFunction, a list of colours or a callable colour map"):
        found = [_color(color) for color in colors]
    if not found:
        raise InvalidValue("cmap is an empty list: give at least one colour")
    return found


def _color(color):
    if isinstance(color, str):
        digits = color[1:]
        try:
            if color[:1] != "#" or len(digits) != 6:
                raise ValueError
            return tuple(int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4))
        except ValueError:
            raise InvalidValue(f"'{color}' is not a colour: use #rrggbb, or (red, green, blue), 0 to 1") from None
    rgb = [float(channel) for channel in color]
    if len(rgb) not in (3, 4):
        raise InvalidValue(f"{color} is not a colour: use #rrggbb, or (red, green, blue), 0 to 1")
    return tuple(rgb[:3])


def _limits(clim):
    if clim is None:
        return None
    with accepting("clim", clim, "two numbers, (lowest, highest)"):
        low, high = (float(value) for value in clim)
    return low, high


def _own_limits(volume, cmap, found):
    """The range over which opacities without values are spread: that of the function, or that of the volume without a cmap."""
    return found.range if cmap is not None else TransferFunction.builtin("grey", volume).range


def _factor(opacity) -> Optional[float]:
    if opacity is None or isinstance(opacity, str) or np.ndim(opacity) != 0:
        return None
    with accepting("opacity", opacity, OPACITY):
        factor = float(opacity)
    if not factor >= 0.0:
        raise InvalidValue(f"opacity is {factor}: expected a number of at least 0")
    return factor


def _points(opacity, limits):
    """Points (value, opacity) of an opacity argument that is not a number."""
    if isinstance(opacity, str):
        if opacity != "linear":
            raise InvalidValue(f"unknown opacity '{opacity}': use linear, a number, (value, opacity) points or an array")
        return [(limits[0], 0.0), (limits[1], 1.0)]
    with accepting("opacity", opacity, OPACITY):
        values = np.asarray(opacity, dtype=float)
    if values.ndim == 2 and values.shape[1] == 2:
        return [tuple(point) for point in values.tolist()]
    if values.ndim != 1 or len(values) == 0:
        raise InvalidValue(f"opacity has the shape {values.shape}: give (value, opacity) points, or one array of opacities")
    return list(zip(np.linspace(*limits, len(values)).tolist(), values.tolist()))
