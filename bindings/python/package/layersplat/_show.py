"""The high-level interface: a volume that shows itself in a notebook, and its picture."""

import pathlib
import sys
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _options
from ._channels import fields_of, labels_of, picture
from ._checks import accepting, cannot_write
from ._errors import InvalidValue
from ._layersplat import Camera, Device, Framing, Labels, LiveScene, Settings, Surface, TransferFunction, Volume
from ._observed import Attribute, Change, Observed
from ._options import DEFAULT
from ._png import png
from ._surfaces import framed, framing_of
from ._transfer import transfer_function
from ._types import Background, Blend, Path, Quality, Shading, Size

Spacing = Optional[Union[float, Tuple[float, float, float]]]
Limits = Optional[Tuple[float, float]]


if TYPE_CHECKING:
    from ._live import Widget

ANGLES = {"azimuth", "elevation", "roll", "zoom", "field_of_view"}
"""Attributes that a camera replaces, and that replace a camera."""


class View(Observed):
    """A view of a volume, which shows itself in a notebook. The attributes below can be set and apply to the next picture.

    size: (width, height) in pixels, or one number for both. azimuth, elevation, roll: camera angles in degrees: about y, above the xz
    plane, about the view direction. zoom: magnification relative to the fitted view. field_of_view: vertical angle of a perspective in
    degrees; None: parallel. camera: a Camera that replaces the angles, zoom and field_of_view; setting one of these sets it to None.
    background: ``transparent``, ``black``, ``white``, ``grey``, ``#rrggbb`` or (red, green, blue), 0 … 1. settings: Settings. transfer:
    the TransferFunction. label_colors: the Labels in whose colours the volume is drawn, see Renderer.set_label_colors; they are given as
    Labels, as an array of ids, or as a file, and cannot be set.

    Where anywidget is installed (``pip install 'layersplat[widget]'``), a notebook shows the viewer's page instead of a picture: drag to
    turn, ``?`` for all keys. camera, settings, transfer, background and label_colors follow the hand, and what is set is shown at once. ``observe``
    calls a handler after each change. The quality ``standard``, which is the default, is refined at rest; others stay as they are.
    """

    size: Attribute[Size] = Attribute()
    azimuth: Attribute[float] = Attribute()
    elevation: Attribute[float] = Attribute()
    roll: Attribute[float] = Attribute()
    zoom: Attribute[float] = Attribute()
    field_of_view: Attribute[Optional[float]] = Attribute()
    camera: Attribute[Optional[Camera]] = Attribute()
    background: Attribute[Background] = Attribute()
    settings: Attribute[Settings] = Attribute()
    transfer: Attribute[TransferFunction] = Attribute()
    label_colors: Attribute[Optional[Labels]] = Attribute()

    def __init__(
        self,
        data: Any,
        spacing: Spacing = None,
        clim: Limits = None,
        cmap: Any = None,
        opacity: Any = None,
        blend: Optional[Blend] = None,
        shade: Optional[Union[bool, Shading]] = None,
        *,
        size: Size = DEFAULT.size,
        azimuth: float = DEFAULT.azimuth,
        elevation: float = DEFAULT.elevation,
        roll: float = DEFAULT.roll,
        zoom: float = DEFAULT.zoom,
        field_of_view: Optional[float] = DEFAULT.field_of_view,
        camera: Optional[Camera] = DEFAULT.camera,
        background: Background = DEFAULT.background,
        quality: Optional[Quality] = DEFAULT.quality,
        settings: Optional[Settings] = DEFAULT.settings,
        device: Optional[Union[Device, str, int]] = DEFAULT.device,
        label_colors: Any = None,
    ) -> None:
        settings = _options.settings(settings, quality, blend, shade)
        if isinstance(data, Volume) and spacing is not None:
            raise InvalidValue("spacing: leave it out, a Volume already has one")
        super().__init__()
        self._widget: Optional["Widget"] = None
        self.volume = data if isinstance(data, Volume) else Volume(data, spacing)
        device = _options.device(device)
        transfer = transfer_function(self.volume, cmap, clim, opacity)
        self._labels = None if label_colors is None else labels_of(label_colors)
        self._scene = LiveScene(self.volume, transfer, device, self._labels)
        self._renderer = self._scene.renderer(transfer)
        self._framed: Optional[Tuple[Tuple[TransferFunction, Settings], Framing]] = None
        angles = {"azimuth": azimuth, "elevation": elevation, "roll": roll, "zoom": zoom, "field_of_view": field_of_view}
        shown = {"size": size, "camera": camera, "background": background, "settings": settings, "transfer": transfer}
        self._values.update(angles, **shown, label_colors=self._labels)

    @property
    def widget(self) -> "Widget":
        """The widget of the live view (anywidget), for layouts of other packages. A notebook shows it by itself."""
        if self._widget is None:
            try:
                from ._live import Widget
            except ImportError as error:
                raise ImportError("a live view needs anywidget: pip install 'layersplat[widget]'") from error
            self._widget = Widget(self)
        return self._widget

    def close(self) -> None:
        """Ends the live view, if it is shown. The view itself can be used, and shown again."""
        if self._widget is not None:
            widget, self._widget = self._widget, None
            widget.close()

    def set_transfer(self, cmap: Any = None, clim: Limits = None, opacity: Any = None) -> None:
        """Sets the transfer function from cmap, clim and opacity, see :func:`layersplat.transfer_function`."""
        self.transfer = transfer_function(self.volume, cmap, clim, opacity)

    def render(self) -> np.ndarray:
        """The picture: (height, width, 4), uint8, straight alpha, row 0 on top."""
        return self._renderer.render(self._camera(), self.size, self.settings, background=self.background)

    def save(self, path: Path) -> None:
        """Writes the picture as a PNG file."""
        with accepting("path", path, "a path: a string or a pathlib.Path"):
            file = pathlib.Path(path)
        picture = self._repr_png_()
        try:
            file.write_bytes(picture)
        except OSError as error:
            raise cannot_write(file, error) from error

    def _camera(self) -> Camera:
        if self.camera is not None:
            return self.camera
        return self._framing().camera(
            self.size,
            azimuth=self.azimuth,
            elevation=self.elevation,
            roll=self.roll,
            zoom=self.zoom,
            field_of_view=self.field_of_view,
        )

    def _framing(self) -> Framing:
        """The framing of the visible part. Cached per transfer function and settings, since it scans all voxels."""
        shown = (self.transfer, self.settings)
        if self._framed is None or self._framed[0] != shown:
            self._framed = (shown, Framing.of(self.volume, *shown))
        return self._framed[1]

    def _with_surfaces(self, surfaces: Sequence[Surface]) -> "View":
        """This view with surfaces in its pictures."""
        if surfaces:
            self._renderer.set_surfaces(surfaces)
            self._framed = ((self.transfer, self.settings), framed(self._framing(), surfaces))
        return self

    @classmethod
    def _of_surfaces(cls, surfaces: Sequence[Surface], *looks: Any, **view: Any) -> "View":
        """A view of surfaces without a volume."""
        framing = framing_of(surfaces)
        if framing is None:
            raise InvalidValue("data is None: give a volume, or surfaces that are visible")
        corners = [surface.bounds for surface in surfaces if surface.visible and surface.bounds]
        lowest, highest = (pick(ends, axis=0) for pick, ends in zip((np.min, np.max), zip(*corners)))
        shown = cls(Volume._around(tuple(lowest), tuple(highest)), None, None, None, 0.0, *looks, **view)
        shown._framed = ((shown.transfer, shown.settings), framing)
        shown._renderer.set_surfaces(surfaces)
        return shown

    def _viewport(self) -> Tuple[int, int]:
        """Width and height in pixels."""
        if isinstance(self.size, int):
            return self.size, self.size
        width, height = self.size
        return width, height

    def _set(self, values: Dict[str, Any]) -> None:
        """Changes attributes by the program, and shows them."""
        if "label_colors" in values:
            raise InvalidValue("label_colors cannot be set: make another View, or use Renderer.set_label_colors")
        if "transfer" in values:
            self._renderer.transfer = values["transfer"]
        if ANGLES & values.keys():
            values = {**values, "camera": None}
        with self._lock:
            changes = self._assign(values)
            if self._widget is not None:
                self._widget.give()
        self._notify(changes)

    def _follow(self, values: Dict[str, Any]) -> List[Change]:
        """Changes attributes by a hand. Returns what has changed. What the page shows stays in place: it is not fitted again."""
        framing = self._framing() if self.camera is None else None
        if "transfer" in values:
            self._renderer.transfer = values["transfer"]
        if "label_changes" in values and self._labels is not None:
            values["label_colors"] = self._labels.changed(values.pop("label_changes"))
            self._renderer.set_label_colors(values["label_colors"])
        changes = self._assign(values)
        if framing is not None:
            self._framed = ((self.transfer, self.settings), framing)
        return changes

    def _show(self) -> None:
        """Settings of the pages."""
        self._scene.show(self.settings, self.background)

    def _ipython_display_(self, **_options: Any) -> None:
        if not _is_live():
            # IPython then asks for the picture.
            raise NotImplementedError
        from IPython.display import display

        # A saved notebook shows the picture, and the widget hides it.
        display({"text/html": self.widget.still_picture(self._repr_png_()), "text/plain": repr(self)}, raw=True)
        display(self.widget)

    def _repr_png_(self) -> bytes:
        return png(self.render())

    def __del__(self) -> None:
        # Otherwise ipywidgets would keep the widget, and with it the voxels.
        if getattr(self, "_widget", None) is not None and not sys.is_finalizing():
            self.close()

    def __repr__(self) -> str:
        return f"<layersplat.View of {self.volume!r}>"


def _is_live() -> bool:
    """Whether this is a notebook's kernel with anywidget."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if getattr(shell, "kernel", None) is None:
        return False
    try:
        import anywidget  # noqa: F401
    except ImportError:
        return False
    return True


def volshow(
    data: Any,
    spacing: Spacing = None,
    clim: Limits = None,
    cmap: Any = None,
    opacity: Any = None,
    blend: Optional[Blend] = None,
    shade: Optional[Union[bool, Shading]] = None,
    **view: Any,
) -> View:
    """Shows a volume in a notebook: returns a View, which displays itself: live where anywidget is installed, otherwise as a picture.

    data: an array (z, y, x) of integers, floats or booleans; an image of nibabel, SimpleITK, ITK or xarray; or a Volume. spacing: voxel
    spacing, one number or one per axis in the order of the data's axes; image objects have their own. cmap, clim, opacity: see
    :func:`transfer_function`. blend: ``composite``, ``maximum``, ``minimum``, ``average`` or ``('iso', value)``. shade: True, False, or
    coefficients, see Settings. Further arguments are those of View.
    """
    if "surfaces" in view:
        raise InvalidValue("surfaces: live views draw none, use render or Renderer.set_surfaces")
    return View(data, spacing, clim, cmap, opacity, blend, shade, **view)


def render(
    data: Any,
    spacing: Spacing = None,
    clim: Any = None,
    cmap: Any = None,
    opacity: Any = None,
    blend: Optional[Blend] = None,
    shade: Optional[Union[bool, Shading]] = None,
    *,
    channel_axis: Optional[int] = None,
    color: Optional[Sequence[Any]] = None,
    factor: Optional[Sequence[float]] = None,
    visible: Optional[Sequence[bool]] = None,
    names: Optional[Sequence[Optional[str]]] = None,
    colors: Optional[str] = None,
    labels: Any = None,
    label_colors: Any = None,
    surfaces: Sequence[Surface] = (),
    **view: Any,
) -> np.ndarray:
    """The picture of :func:`volshow`: (height, width, 4), uint8, straight alpha, row 0 on top.

    Several volumes are drawn together: a list of them, or of Channels, with Colors and Labels among them; an array of four axes with
    channel_axis; or an xarray with a dimension ``c`` or ``channel``. cmap, clim, opacity, color, factor, visible and names are lists then, see :func:`channels`. colors: ``direct`` for an array (z, y, x, 3) or
    (z, y, x, 4) of colours, ``direction`` for (z, y, x, 3) of vectors, see Colors. labels: True for an array of ids, or their table, see Labels. data may also be a Colors or a Labels.
    label_colors: draws the volume in the colours of labels: Labels, an array of ids, or a file; labels is their table then. surfaces: a list of
    Mesh, Spheres and Tubes in and around the volume, which the view is fitted to, too; data may then be None.
    """
    if data is None:
        looks = {"spacing": spacing, "clim": clim, "cmap": cmap, "opacity": opacity, "colors": colors, "labels": labels}
        for name, given in looks.items():
            if given is not None:
                raise InvalidValue(f"{name}: leave it out, there is no volume")
        return View._of_surfaces(surfaces, blend, shade, **view).render()
    options = {"clim": clim, "cmap": cmap, "opacity": opacity, "color": color, "factor": factor, "visible": visible, "names": names}
    if label_colors is not None:
        label_colors, labels = labels_of(label_colors, None if labels is True else labels), None
    fields = fields_of(data, spacing, options, channel_axis, colors, labels, blend)
    if fields is None:
        shown = View(data, spacing, clim, cmap, opacity, blend, shade, label_colors=label_colors, **view)
        return shown._with_surfaces(surfaces).render()
    if label_colors is not None:
        raise InvalidValue("label_colors: leave it out, they are for a single volume of values")
    return picture(fields, surfaces, blend, shade, **view)
