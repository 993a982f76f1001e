"""Types of the native module. Use `help()` for the documentation."""

from typing import Any, Callable, Dict, List, Literal, Optional, Sequence, Tuple, Union, final

import numpy as np
from numpy.typing import NDArray

from ._types import AmbientOcclusion, Background, Blend, Handle, Path, Point, Quality, Shading, Shadows, Size, Vector

__all__ = [
    "Camera",
    "Device",
    "DeviceVolume",
    "Event",
    "Framing",
    "LivePage",
    "LiveScene",
    "PAGE_MODULE",
    "Renderer",
    "Settings",
    "TransferFunction",
    "Volume",
    "__version__",
    "wait_for_interrupted_calls",
]

__version__: str

PAGE_MODULE: str
"""The viewer's page as one ES module, for anywidget."""

def wait_for_interrupted_calls() -> None: ...

@final
class Volume:
    def __new__(
        cls,
        data: Any,
        spacing: Optional[Union[float, Sequence[float]]] = None,
        *,
        background: Optional[float] = None,
        name: Optional[str] = None,
    ) -> Volume: ...
    @staticmethod
    def open(
        path: Path,
        *,
        dims: Optional[Tuple[int, int, int]] = None,
        voxel_type: Optional[str] = None,
        spacing: Optional[Vector] = None,
        endian: Optional[Literal["little", "big"]] = None,
        header_bytes: Optional[int] = None,
        background: Optional[float] = None,
        frame: Optional[int] = None,
        channel: Optional[int] = None,
        array: Optional[str] = None,
        series: Optional[str] = None,
        level: Optional[int] = None,
    ) -> Volume: ...
    @property
    def shape(self) -> Tuple[int, int, int]: ...
    @property
    def dtype(self) -> str: ...
    @property
    def spacing(self) -> Point: ...
    @property
    def origin(self) -> Point: ...
    @property
    def centre(self) -> Point: ...
    @property
    def range(self) -> Tuple[float, float]: ...
    @property
    def background(self) -> float: ...
    @property
    def invalid(self) -> int: ...
    @property
    def name(self) -> str: ...

@final
class TransferFunction:
    def __new__(
        cls,
        colors: Sequence[Tuple[float, Sequence[float]]],
        opacities: Sequence[Tuple[float, float]],
        *,
        name: str = "given",
    ) -> TransferFunction: ...
    @staticmethod
    def builtin(name: str, onto: Union[Volume, Tuple[float, float]]) -> TransferFunction: ...
    @staticmethod
    def automatic(volume: Volume) -> TransferFunction: ...
    @staticmethod
    def open(source: Path, volume: Volume) -> TransferFunction: ...
    def stretched(self, lo: float, hi: float) -> TransferFunction: ...
    def faded(self, factor: float) -> TransferFunction: ...
    def color(self, value: float) -> Point: ...
    def opacity(self, value: float) -> float: ...
    @property
    def colors(self) -> Sequence[Tuple[float, Point]]: ...
    @property
    def opacities(self) -> Sequence[Tuple[float, float]]: ...
    @property
    def range(self) -> Tuple[float, float]: ...
    @property
    def name(self) -> str: ...
    def __eq__(self, other: object, /) -> bool: ...

@final
class Settings:
    def __new__(
        cls,
        quality: Optional[Quality] = None,
        *,
        algorithm: Literal["layered", "axis-sheets", "view-sheets", "slicing", "raycast"] = "layered",
        kernel: Optional[Literal["cubic", "linear", "catmull-rom", "bspline", "gaussian"]] = None,
        samples_per_layer: Optional[int] = None,
        density: Optional[int] = None,
        layer_axis: Optional[Literal["auto", "x", "y", "z"]] = None,
        step: Optional[float] = None,
        sheet_distance: Optional[float] = None,
        blend: Optional[Blend] = None,
        shading: Optional[Union[bool, Shading]] = None,
        light_space: Literal["world", "camera"] = "world",
        shadows: Union[bool, float, Shadows] = False,
        ambient_occlusion: Union[bool, AmbientOcclusion] = False,
        light_grid: Literal["full", "half", "quarter"] = "full",
        gradient: Optional[str] = None,
        gradient_opacity: Optional[Sequence[Tuple[float, float]]] = None,
        depth_cue: Optional[Union[float, Tuple[float, Tuple[float, float, float]]]] = None,
        crop: Optional[Tuple[Vector, Vector]] = None,
        planes: Optional[Sequence[Tuple[Vector, Vector]]] = None,
        unit_distance: Optional[float] = None,
        extinction: Literal["exponential", "linear"] = "exponential",
        early_termination: bool = True,
    ) -> Settings: ...
    def __eq__(self, other: object, /) -> bool: ...

@final
class Camera:
    def __new__(
        cls,
        position: Vector,
        focal_point: Vector,
        view_up: Vector = ...,
        *,
        scale: Optional[float] = None,
        field_of_view: Optional[float] = None,
    ) -> Camera: ...
    @staticmethod
    def orbit(
        centre: Vector,
        distance: float,
        *,
        azimuth: float = 0.0,
        elevation: float = 0.0,
        roll: float = 0.0,
        scale: Optional[float] = None,
        field_of_view: Optional[float] = None,
    ) -> Camera: ...
    @property
    def position(self) -> Point: ...
    @property
    def focal_point(self) -> Point: ...
    @property
    def view_up(self) -> Point: ...
    @property
    def scale(self) -> Optional[float]: ...
    @property
    def field_of_view(self) -> Optional[float]: ...
    def __eq__(self, other: object, /) -> bool: ...

@final
class Framing:
    @staticmethod
    def of(volume: Volume, transfer: TransferFunction, settings: Optional[Settings] = None) -> Framing: ...
    @staticmethod
    def whole(volume: Volume) -> Framing: ...
    @property
    def centre(self) -> Point: ...
    def camera(
        self,
        size: Size,
        *,
        azimuth: float = 0.0,
        elevation: float = 0.0,
        roll: float = 0.0,
        zoom: float = 1.0,
        field_of_view: Optional[float] = None,
        centre: Optional[Vector] = None,
    ) -> Camera: ...

@final
class Device:
    def __new__(
        cls,
        name: Optional[Union[str, int]] = None,
        *,
        context: Optional[Handle] = None,
        device: Optional[Handle] = None,
        queue: Optional[Handle] = None,
        memory: Optional[int] = None,
    ) -> Device: ...
    @staticmethod
    def list() -> Sequence[Dict[str, Any]]: ...
    @property
    def name(self) -> str: ...
    @property
    def platform(self) -> str: ...
    @property
    def context(self) -> int: ...
    @property
    def id(self) -> int: ...
    @property
    def queue(self) -> int: ...
    @property
    def memory(self) -> Optional[int]: ...
    @property
    def allocated_bytes(self) -> int: ...

@final
class DeviceVolume:
    def __new__(
        cls,
        device: Device,
        buffer: Handle,
        shape: Tuple[int, int, int],
        dtype: Any,
        *,
        spacing: Optional[Union[float, Sequence[float]]] = None,
        first: int = 0,
        pitches: Optional[Tuple[int, int]] = None,
        range: Optional[Tuple[float, float]] = None,
        background: Optional[float] = None,
        wait_for: Optional[Sequence[Union[Event, Handle]]] = None,
        name: str = "buffer",
    ) -> DeviceVolume: ...
    @property
    def shape(self) -> Tuple[int, int, int]: ...
    @property
    def dtype(self) -> str: ...
    @property
    def spacing(self) -> Point: ...
    @property
    def centre(self) -> Point: ...
    @property
    def range(self) -> Tuple[float, float]: ...

@final
class Event:
    @property
    def int_ptr(self) -> int: ...
    def wait(self) -> None: ...
    @property
    def is_complete(self) -> bool:
        """Raises DeviceError if the command, or one in its wait list, has failed."""
        ...
    def to_pyopencl(self) -> Any: ...

@final
class LiveScene:
    """The voxels of a View on a device, shared by its renderer and its pages. Not for users."""

    def __new__(cls, volume: Volume, transfer: TransferFunction, device: Device) -> LiveScene: ...
    def renderer(self, transfer: TransferFunction) -> Renderer: ...
    def show(self, settings: Settings, background: Background) -> None: ...
    def page(self, camera: Camera, transfer: TransferFunction, send: Callable[[Optional[str], Optional[bytes]], Any]) -> LivePage: ...

@final
class LivePage:
    """A page of a LiveScene. Not for users."""

    def receive(self, message: str, follow: bool) -> List[Tuple[str, Any]]: ...
    def give(self, camera: Camera, transfer: TransferFunction) -> None: ...
    def close(self) -> None: ...

@final
class Renderer:
    def __new__(
        cls,
        volume: Any,
        transfer: Optional[TransferFunction] = None,
        *,
        device: Optional[Union[Device, str, Handle]] = None,
        context: Optional[Handle] = None,
        queue: Optional[Handle] = None,
        time_limit: Optional[float] = None,
    ) -> Renderer: ...
    def render(
        self,
        camera: Camera,
        size: Size,
        settings: Optional[Settings] = None,
        *,
        background: Background = "black",
    ) -> NDArray[np.uint8]: ...
    def render_float(self, camera: Camera, size: Size, settings: Optional[Settings] = None) -> NDArray[np.float32]: ...
    def depths(
        self, camera: Camera, size: Size, settings: Optional[Settings] = None
    ) -> Tuple[NDArray[np.float32], NDArray[np.float32]]: ...
    def enqueue(
        self,
        camera: Camera,
        size: Size,
        onto: Handle,
        settings: Optional[Settings] = None,
        *,
        format: Literal["rgba8", "float"] = "rgba8",
        background: Background = "black",
        first: int = 0,
        row_pitch: Optional[int] = None,
        wait_for: Optional[Sequence[Union[Event, Handle]]] = None,
    ) -> Event: ...
    def prepare(self, camera: Camera, size: Size, settings: Optional[Settings] = None) -> None: ...
    def volume_changed(self, wait_for: Optional[Sequence[Union[Event, Handle]]] = None) -> Event: ...
    def cancel(self) -> None: ...
    def set_volume(self, volume: Any) -> None: ...
    def stream_plan(self, camera: Camera, size: Size, settings: Optional[Settings] = None) -> Optional[Dict[str, Any]]: ...
    @property
    def time_limit(self) -> Optional[float]: ...
    @time_limit.setter
    def time_limit(self, time_limit: Optional[float]) -> None: ...
    def camera(
        self,
        size: Size,
        *,
        azimuth: float = 0.0,
        elevation: float = 0.0,
        roll: float = 0.0,
        zoom: float = 1.0,
        field_of_view: Optional[float] = None,
    ) -> Camera: ...
    @property
    def transfer(self) -> TransferFunction: ...
    @transfer.setter
    def transfer(self, transfer: TransferFunction) -> None: ...
