"""Channels from arrays, and pictures of channels, colours and labels."""

import os
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _images, _options
from ._checks import accepting
from ._errors import InvalidType, InvalidValue
from ._layersplat import Channel, Colors, Labels, Renderer, Surface, TransferFunction, Volume, channel_colors
from ._surfaces import framed
from ._transfer import _color, transfer_function
from ._types import Blend, Shading

GATHERING = ("maximum", "minimum", "average")
"""Blend modes that show values: their colours rise from black."""


def channels(
    data: Any,
    spacing: Any = None,
    clim: Any = None,
    cmap: Any = None,
    opacity: Any = None,
    *,
    channel_axis: Optional[int] = None,
    color: Optional[Sequence[Any]] = None,
    factor: Optional[Sequence[float]] = None,
    visible: Optional[Sequence[bool]] = None,
    names: Optional[Sequence[Optional[str]]] = None,
    blend: Optional[Blend] = None,
) -> List[Channel]:
    """Channels that :func:`render` and a Renderer draw together.

    data: a list of volumes, arrays (z, y, x), images or Channels, of any grids; an array of four axes with channel_axis, the index of the
    axis of channels; or an xarray with a dimension ``c`` or ``channel``, whose coordinates may be names. spacing: of all channels, one
    number or three in the order of the axes. clim, cmap, opacity: lists with an item per channel, which is None or what
    :func:`transfer_function` takes. color: a list of colours, ``#rrggbb`` or (red, green, blue), or None. factor, visible: lists for the
    extinctions and visibilities, see Channel. names: names of the channels, of which a fluorophore gives the colour. blend: the mode in which
    they will be drawn; colours rise from black in ``maximum``, ``minimum`` and ``average``.

    Colours that are not given are well separated, also for the colour-blind: green, magenta, cyan, yellow, red, blue; a single channel is
    white. By default opacities rise from the end of the background's noise to the 99.9th percentile of the voxels.
    """
    parts, found = _split(data, channel_axis)
    count = len(parts)
    names = found if names is None else _each("names", names, count)
    lists = [_each(name, values, count) for name, values in [("clim", clim), ("cmap", cmap), ("opacity", opacity), ("color", color)]]
    factors, visibilities = _each("factor", factor, count), _each("visible", visible, count)
    automatic = channel_colors([None if name is None else str(name) for name in names])
    made = []
    for n, part in enumerate(parts):
        limits, colors, opacities, own = (values[n] for values in lists)
        chosen = any(value is not None for value in (limits, colors, opacities, own))
        if not isinstance(part, Channel):
            volume = part if isinstance(part, Volume) else Volume(part, spacing, name=names[n] or f"channel {n}")
            part, chosen = Channel(volume, TransferFunction.builtin("grey", volume)), True
        if chosen:
            shade = automatic[n] if own is None else _color(own)
            ramp = isinstance(blend, str) and blend in GATHERING
            base = TransferFunction.channel(part.volume, shade, ramp=ramp) if colors is None else colors
            part = part.replaced(transfer=transfer_function(part.volume, base, limits, opacities))
        made.append(part.replaced(factor=factors[n], visible=visibilities[n]))
    return made


def are_channels(data: Any) -> bool:
    """Whether data are several volumes: a list of them, or an xarray with a dimension of channels."""
    if isinstance(data, Channel) or _images.channel_dimension(data) is not None:
        return True
    if not isinstance(data, (list, tuple)) or not data:
        return False
    return all(isinstance(one, (Channel, Volume)) or _images.is_image(one) or (isinstance(one, np.ndarray) and one.ndim == 3) for one in data)


def _split(data: Any, channel_axis: Optional[int]) -> Tuple[List[Any], List[Optional[str]]]:
    """The volumes of all channels, and their names."""
    dimension = _images.channel_dimension(data)
    if channel_axis is None and dimension is not None:
        count = data.sizes[dimension]
        coordinates = data.coords[dimension].values if dimension in data.coords else [None] * count
        names = [str(name) if isinstance(name, str) else None for name in coordinates]
        return [data.isel({dimension: n}, drop=True) for n in range(count)], names
    if isinstance(data, Channel):
        return [data], [None]
    if channel_axis is None:
        if not isinstance(data, (list, tuple)):
            raise InvalidType(f"data is of type {type(data).__name__}: give a list of volumes, or an array with channel_axis")
        return list(data), [None] * len(data)
    with accepting("data", data, "an array with an axis of channels"):
        array = np.asanyarray(data)
    if array.ndim != 4:
        raise InvalidValue(f"the array has {array.ndim} axes: with channel_axis give four, the channels and z, y, x")
    with accepting("channel_axis", channel_axis, "the index of an axis"):
        array = np.moveaxis(array, channel_axis, 0)
    return list(array), [None] * len(array)


def _each(name: str, values: Any, count: int) -> List[Any]:
    """A list with an item per channel."""
    if values is None:
        return [None] * count
    if isinstance(values, str) or not hasattr(values, "__len__") or len(values) != count:
        raise InvalidValue(f"{name}: give a list with an item for each of the {count} channels")
    return list(values)


Fields = Union[Sequence[Union[Channel, Colors, Labels]], Colors, Labels]


def fields_of(
    data: Any, spacing: Any, options: Dict[str, Any], channel_axis: Optional[int], colors: Optional[str], labels: Any, blend: Any
) -> Optional[Fields]:
    """What :func:`render` draws; None for one scalar volume. options: those of channels that are lists."""
    if colors not in (None, "direct", "direction"):
        raise InvalidValue(f"colors is {colors!r}: expected direct or direction, or leave it out")
    if sum([channel_axis is not None, colors is not None, labels is not None]) > 1:
        raise InvalidValue("give one of channel_axis, colors and labels")
    is_made = isinstance(data, (Colors, Labels))
    if is_made or colors is not None or labels is not None:
        _refuse(options, "colours and labels have their own")
        if is_made:
            return data
        if labels is not None:
            return Labels(data, None if labels is True else labels, spacing)
        return Colors(data, spacing, direction=colors == "direction")
    if isinstance(data, (list, tuple)) and any(isinstance(one, (Colors, Labels)) for one in data):
        _refuse(options, "give them to channels(), and add colours and labels to its list")
        volumes = [one for one in data if not isinstance(one, (Colors, Labels))]
        together: List[Union[Channel, Colors, Labels]] = [*channels(volumes, spacing, blend=blend)] if volumes else []
        return together + [one for one in data if isinstance(one, (Colors, Labels))]
    if channel_axis is None and not are_channels(data):
        _refuse({name: value for name, value in options.items() if name not in ("clim", "cmap", "opacity")}, "there is one volume")
        return None
    return channels(data, spacing, channel_axis=channel_axis, blend=blend, **options)


def _refuse(options: Dict[str, Any], reason: str) -> None:
    given = [name for name, value in options.items() if value is not None]
    if given:
        raise InvalidValue(f"{', '.join(given)}: leave out, {reason}")


def labels_of(given: Any, table: Any = None) -> Labels:
    """Labels that colour a volume: Labels, a file, or ids of voxels, the last two possibly with a table."""
    if isinstance(given, Labels):
        if table is not None:
            raise InvalidValue("labels: leave it out, the Labels have a table")
        return given
    return Labels.open(given, table) if isinstance(given, (str, os.PathLike)) else Labels(given, table)


def picture(
    fields: Fields,
    surfaces: Sequence[Surface] = (),
    blend: Optional[Blend] = None,
    shade: Optional[Union[bool, Shading]] = None,
    **view: Any,
) -> np.ndarray:
    """The picture of channels, colours or labels with surfaces, with the options of View."""
    options = _options.ViewOptions(**view)
    settings = _options.settings(options.settings, options.quality, blend, shade)
    if not isinstance(fields, (Colors, Labels)):
        # Hidden channels do not count, unless there are no others.
        shown = [field for field in fields if not isinstance(field, Channel) or field.visible] or fields
        framings = [field.framing(settings) if isinstance(field, Channel) else field.framing() for field in shown]
        framing = framings[0]
        for other in framings[1:]:
            framing = framing.joined(other)
    else:
        framing = fields.framing()
    renderer = Renderer(fields, device=_options.device(options.device))
    if surfaces:
        renderer.set_surfaces(surfaces)
    return renderer.render(options.camera_for(framed(framing, surfaces)), options.size, settings, background=options.background)
