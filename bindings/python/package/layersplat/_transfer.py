"""Transfer functions from what plotting packages call cmap, clim and opacity."""

from typing import Any, Optional, Tuple

import numpy as np

from ._checks import accepting
from ._errors import InvalidValue
from ._layersplat import TransferFunction, Volume

SAMPLES = 256
"""Samples that are taken of a colour map."""
OPACITY = "a number, linear, (value, opacity) points or an array of opacities"


def transfer_function(
    volume: Volume, cmap: Any = None, clim: Optional[Tuple[float, float]] = None, opacity: Any = None
) -> TransferFunction:
    """The transfer function of a volume that these say.

    cmap: one of the names that ``layersplat transfer --list`` tells, as ``grey``, ``viridis`` or ``inferno_r``; a file of ParaView or 3D Slicer; a TransferFunction; a list of colours, evenly spaced, each
    (red, green, blue), 0 … 1, or ``#rrggbb``; or something to call that maps numbers 0 … 1 to colours, as matplotlib's colour maps do (of
    which opacities do not count).
    clim: values (lowest, highest) that it is stretched onto; the volume's range by default, or what the function or file says itself.
    opacity: a number that all opacities are multiplied by; ``linear``, from 0 to 1 over clim; a list of (value, opacity); or an array of
    opacities, evenly spaced over clim. Opacities are per unit distance, see Settings. By default the map's own, or one that rises slowly.

    With nothing but a number for opacity given, it is made from the volume's histogram.
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
    """Colours, with opacities of their own."""
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
    """Colours of something to call."""
    made = cmap(np.linspace(0.0, 1.0, SAMPLES))
    with accepting("what cmap returned", made, "an array of colours, red, green and blue"):
        rgba = np.asarray(made, dtype=float)
    if rgba.ndim != 2 or rgba.shape[0] != SAMPLES or rgba.shape[1] < 3:
        raise InvalidValue(f"cmap made {rgba.shape} of {SAMPLES} numbers: expected a colour of each, red, green, blue")
    return [tuple(color) for color in np.clip(rgba[:, :3], 0.0, 1.0).tolist()]


def _listed(colors):
    """Colours of a list."""
    with accepting("cmap", colors, "a name, a file, a TransferFunction, a list of colours or a colour map to call"):
        found = [_color(color) for color in colors]
    if not found:
        raise InvalidValue("cmap is a list without a colour: give at least one")
    return found


def _color(color):
    if isinstance(color, str):
        digits = color[1:]
        try:
            if color[:1] != "#" or len(digits) != 6:
                raise ValueError
            return tuple(int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4))
        except ValueError:
            raise InvalidValue(f"'{color}' is no colour: use #rrggbb, or (red, green, blue), 0 to 1") from None
    rgb = [float(channel) for channel in color]
    if len(rgb) not in (3, 4):
        raise InvalidValue(f"{color} is no colour: use #rrggbb, or (red, green, blue), 0 to 1")
    return tuple(rgb[:3])


def _limits(clim):
    if clim is None:
        return None
    with accepting("clim", clim, "two numbers, (lowest, highest)"):
        low, high = (float(value) for value in clim)
    return low, high


def _own_limits(volume, cmap, found):
    """What opacities without values are spread over: what the function covers, or the volume's values where it has none of its own."""
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
    """(value, opacity) of everything but a number."""
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
