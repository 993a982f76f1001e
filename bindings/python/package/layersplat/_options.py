"""The options of views, and settings and device from them."""

from typing import Any, NamedTuple, Optional, Union

from . import _default
from ._errors import InvalidValue
from ._layersplat import Camera, Device, Framing, Settings
from ._types import Background, Quality, Size


class ViewOptions(NamedTuple):
    """The options of View besides what it shows, with their defaults."""

    size: Size = (512, 512)
    azimuth: float = 30.0
    elevation: float = 20.0
    roll: float = 0.0
    zoom: float = 1.0
    field_of_view: Optional[float] = None
    camera: Optional[Camera] = None
    background: Background = "black"
    quality: Optional[Quality] = None
    settings: Optional[Settings] = None
    device: Optional[Union[Device, str, int]] = None

    def camera_for(self, framing: Framing) -> Camera:
        """The camera, by default one that shows what is framed."""
        if self.camera is not None:
            return self.camera
        return framing.camera(
            self.size,
            azimuth=self.azimuth,
            elevation=self.elevation,
            roll=self.roll,
            zoom=self.zoom,
            field_of_view=self.field_of_view,
        )


DEFAULT = ViewOptions()


def settings(given: Optional[Settings], quality: Any, blend: Any, shade: Any) -> Settings:
    """The given settings, or those of the other options."""
    options = [name for name, value in [("blend", blend), ("shade", shade), ("quality", quality)] if value is not None]
    if given is None:
        return Settings(quality, blend=blend, shading=shade)
    if options:
        raise InvalidValue(f"settings already contain {' and '.join(options)}: give either")
    return given


def device(given: Optional[Union[Device, str, int]]) -> Device:
    """The given device, or the default one."""
    if given is None:
        return _default.device()
    return given if isinstance(given, Device) else Device(given)
