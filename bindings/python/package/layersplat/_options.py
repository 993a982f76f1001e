"""Settings and device from the options of views."""

from typing import Any, Optional, Union

from . import _default
from ._errors import InvalidValue
from ._layersplat import Device, Settings


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
