"""The short things: a volume that shows itself, and its picture."""

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
    """A volume as it is seen: shows itself in a notebook. Everything below can be set, and the next picture is of it.

    size: (width, height) in pixels, or one number. azimuth, elevation, roll: where the camera stands, in degrees, about y, above the xz
    plane, about the view. zoom: how many times larger than fitted. field_of_view: vertical, degrees, of a perspective; None: parallel.
    camera: a Camera instead of all these but the size. background: ``transparent``, ``black``, ``white``, ``grey``, ``#rrggbb`` or
    (red, green, blue), 0 … 1. settings: Settings.
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
        given = [name for name, value in [("blend", blend), ("shade", shade), ("quality", quality)] if value is not None]
        if settings is not None and given:
            raise InvalidValue(f"settings say {' and '.join(given)} too: give either")
        if isinstance(data, Volume) and spacing is not None:
            raise InvalidValue("spacing: a Volume has one already, leave it out")
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
        """Takes the transfer function that these say, see :func:`layersplat.transfer_function`."""
        self.transfer = transfer_function(self.volume, cmap, clim, opacity)

    def render(self) -> np.ndarray:
        """The picture: (height, width, 4), uint8, straight alpha, row 0 on top."""
        return self._renderer.render(self._camera(), self.size, self.settings, background=self.background)

    def save(self, path: Path) -> None:
        """Writes the picture as a PNG file."""
        with accepting("path", path, "a path, a string or an object of pathlib"):
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
        """The outline of what is shown: found once for a transfer function and settings, since that looks at all voxels."""
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
    """Shows a volume: the result shows itself in a notebook.

    data: an array (z, y, x) of integers, floats or booleans; an image of nibabel, SimpleITK, ITK or xarray; or a Volume. spacing: distance
    of voxels, one number or one per axis in the data's own order; image objects have their own. cmap, clim, opacity: see
    :func:`transfer_function`. blend: ``composite``, ``maximum``, ``minimum``, ``average`` or ``('iso', value)``. shade: True, False, or
    numbers, see Settings. Further arguments are those of View.
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
