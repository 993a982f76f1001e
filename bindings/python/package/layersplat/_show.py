"""The high-level interface: a volume that shows itself in a notebook, and its picture."""

import pathlib
from typing import Any, Optional, Tuple, Union

import numpy as np

from . import _default
from ._checks import accepting, cannot_write
from ._errors import InvalidValue
from ._layersplat import Camera, Device, Framing, Renderer, Settings, TransferFunction, Volume
from ._png import png
from ._transfer import transfer_function
from ._types import Background, Blend, Path, Quality, Shading, Size

Spacing = Optional[Union[float, Tuple[float, float, float]]]
Limits = Optional[Tuple[float, float]]


class View:
    """A view of a volume, which shows itself in a notebook. The attributes below can be set and apply to the next picture.

    size: (width, height) in pixels, or one number for both. azimuth, elevation, roll: camera angles in degrees: about y, above the xz
    plane, about the view direction. zoom: magnification relative to the fitted view. field_of_view: vertical angle of a perspective in
    degrees; None: parallel. camera: a Camera that replaces the angles, zoom and field_of_view. background: ``transparent``, ``black``,
    ``white``, ``grey``, ``#rrggbb`` or (red, green, blue), 0 … 1. settings: Settings.
    """

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
        size: Size = (512, 512),
        azimuth: float = 30.0,
        elevation: float = 20.0,
        roll: float = 0.0,
        zoom: float = 1.0,
        field_of_view: Optional[float] = None,
        camera: Optional[Camera] = None,
        background: Background = "black",
        quality: Optional[Quality] = None,
        settings: Optional[Settings] = None,
        device: Optional[Union[Device, str, int]] = None,
    ) -> None:
        options = [name for name, value in [("blend", blend), ("shade", shade), ("quality", quality)] if value is not None]
        if settings is not None and options:
            raise InvalidValue(f"settings already contain {' and '.join(options)}: give either")
        if isinstance(data, Volume) and spacing is not None:
            raise InvalidValue("spacing: leave it out, a Volume already has one")
        self.volume = data if isinstance(data, Volume) else Volume(data, spacing)
        self.settings = Settings(quality, blend=blend, shading=shade) if settings is None else settings
        self.size, self.background = size, background
        self.azimuth, self.elevation, self.roll = azimuth, elevation, roll
        self.zoom, self.field_of_view, self.camera = zoom, field_of_view, camera
        if device is None:
            device = _default.device()
        elif not isinstance(device, Device):
            device = Device(device)
        transfer = transfer_function(self.volume, cmap, clim, opacity)
        self._renderer = Renderer(self.volume, transfer, device=device)
        self._framed: Optional[Tuple[Tuple[TransferFunction, Settings], Framing]] = None

    @property
    def transfer(self) -> TransferFunction:
        """The transfer function."""
        return self._renderer.transfer

    @transfer.setter
    def transfer(self, transfer: TransferFunction) -> None:
        self._renderer.transfer = transfer

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

    def _repr_png_(self) -> bytes:
        return png(self.render())

    def __repr__(self) -> str:
        return f"<layersplat.View of {self.volume!r}>"


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
    """Shows a volume in a notebook: returns a View, which displays itself.

    data: an array (z, y, x) of integers, floats or booleans; an image of nibabel, SimpleITK, ITK or xarray; or a Volume. spacing: voxel
    spacing, one number or one per axis in the order of the data's axes; image objects have their own. cmap, clim, opacity: see
    :func:`transfer_function`. blend: ``composite``, ``maximum``, ``minimum``, ``average`` or ``('iso', value)``. shade: True, False, or
    coefficients, see Settings. Further arguments are those of View.
    """
    return View(data, spacing, clim, cmap, opacity, blend, shade, **view)


def render(
    data: Any,
    spacing: Spacing = None,
    clim: Limits = None,
    cmap: Any = None,
    opacity: Any = None,
    blend: Optional[Blend] = None,
    shade: Optional[Union[bool, Shading]] = None,
    **view: Any,
) -> np.ndarray:
    """The picture of :func:`volshow`: (height, width, 4), uint8, straight alpha, row 0 on top."""
    return View(data, spacing, clim, cmap, opacity, blend, shade, **view).render()
