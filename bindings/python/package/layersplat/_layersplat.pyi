"""Types and documentation of the native module. `docstrings` writes the latter from the module itself."""

from typing import Any, Callable, Dict, List, Literal, Optional, Sequence, Tuple, Union, final

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self, disjoint_base

from ._types import AmbientOcclusion, Background, Blend, Handle, Path, Point, Quality, Shading, Shadows, Size, Sky, Vector

__all__ = [
    "Camera",
    "Channel",
    "Colors",
    "Device",
    "DeviceVolume",
    "Event",
    "Framing",
    "Labels",
    "LivePage",
    "LiveScene",
    "PAGE_MODULE",
    "Playback",
    "Renderer",
    "Settings",
    "Slice",
    "Surface",
    "TransferFunction",
    "Volume",
    "VolumeSequence",
    "__version__",
    "channel_colors",
    "wait_for_interrupted_calls",
]

__version__: str

PAGE_MODULE: str
"""The viewer's page as one ES module, for anywidget."""

def wait_for_interrupted_calls() -> None:
    """Waits until the worker threads of all interrupted calls have ended. Python calls it at exit, since a driver that is unloaded while a
    kernel runs crashes the process. Another signal ends the wait.
    """

@final
class Volume:
    """A scalar volume: voxels, their grid in the world, and a background value.

    Volume(data) takes an array (z, y, x), or an image of nibabel (x, y, z), SimpleITK, ITK or xarray.

    data: integers, floats or booleans, of any strides and byte order. The volume keeps a copy, so the array may change afterwards.
    Immutable memory is not copied: bytes (numpy.frombuffer), and files mapped read-only (numpy.memmap and numpy.load with mode "r"), of
    uint8, int8, uint16, int16 or float32. Wider types are converted. Masked voxels, and floats that are NaN, infinite or beyond ±1e30,
    count as background. spacing: voxel spacing in world units, above 0: one number, or one per axis in the order of the data's axes. The
    default is 1, or the spacing of an image object. background: the value around the volume and of voxels without a value; by default
    the smallest value. name: shown in messages.

    Warns (DataWarning) about values that are NaN, infinite or beyond ±1e30, and about integers that 32-bit floats cannot distinguish.
    Raises InvalidValue if data does not have three axes, has an unsupported type, or has a sheared grid.
    """

    def __new__(
        cls,
        data: Any,
        spacing: Optional[Union[float, Sequence[float]]] = None,
        *,
        background: Optional[float] = None,
        name: Optional[str] = None,
    ) -> Volume: ...
    @staticmethod
    def _around(lowest: Vector, highest: Vector) -> Volume:
        """Zeros on a coarse grid around a box."""
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
        channel: Optional[Union[int, Literal["magnitude"]]] = None,
        array: Optional[str] = None,
        series: Optional[str] = None,
        level: Optional[int] = None,
        region: Optional[Tuple[Tuple[int, int], Tuple[int, int], Tuple[int, int]]] = None,
        download: Optional[int] = None,
        missing: Optional[Literal["refuse", "fill"]] = None,
    ) -> Volume:
        """Opens a file, or builtin:marschner-lobb, builtin:hydrogen or builtin:cube with @N or @XxYxZ.

        dims: number of voxels along x, y, z. voxel_type, endian (little or big), header_bytes: properties of a raw file that its name
        does not contain. spacing: along x, y, z. background: as for Volume(data). frame: index of one of several volumes; VolumeSequence
        opens all. channel: index of one of several components per voxel, or "magnitude", which is the default for those that a file
        declares as a vector. array: a dataset, by name or path. series: a DICOM series in a folder. level: resolution level, 0 is the
        finest. region: ((x0, x1), (y0, y1), (z0, z1)), the part of a Zarr to read as if it were all, in voxels of level 0, without the
        last ones. Of URLs: download, the most bytes of voxels, 2 GB by default; missing: chunks that the server refuses are an error
        ("refuse"), or not stored ("fill").
        """
    @property
    def shape(self) -> Tuple[int, int, int]:
        """Number of voxels along z, y, x."""
    @property
    def dtype(self) -> str:
        """Voxel type on the device: uint8, int8, uint16, int16 or float32."""
    @property
    def spacing(self) -> Point:
        """Voxel spacing along x, y, z, in world units."""
    @property
    def origin(self) -> Point:
        """World position (x, y, z) of voxel (0, 0, 0)."""
    @property
    def centre(self) -> Point:
        """World position (x, y, z) of the centre."""
    @property
    def range(self) -> Tuple[float, float]:
        """Smallest and largest value."""
    @property
    def background(self) -> float:
        """The value around the volume and of voxels without a value."""
    @property
    def invalid(self) -> int:
        """Number of voxels without a value: NaN, infinite or beyond ±1e30."""
    @property
    def name(self) -> str:
        """The name shown in messages."""

@final
class VolumeSequence:
    """Volumes of one shape and type in the order of time: the frames of a file, or of several files. Made by VolumeSequence.open.

    It has a length; sequence[n] reads a step as a Volume, also with n < 0. Iterating (for volume in sequence) reads each step on another
    thread while the one before is in use. Renderer.set_volume shows a step.
    """

    @staticmethod
    def open(
        paths: Union[Path, Sequence[Path]],
        *,
        dims: Optional[Tuple[int, int, int]] = None,
        voxel_type: Optional[str] = None,
        spacing: Optional[Vector] = None,
        endian: Optional[Literal["little", "big"]] = None,
        header_bytes: Optional[int] = None,
        background: Optional[float] = None,
        channel: Optional[Union[int, Literal["magnitude"]]] = None,
        array: Optional[str] = None,
        series: Optional[str] = None,
        level: Optional[int] = None,
    ) -> VolumeSequence:
        """Opens the frames of a file with a time axis, of a .pvd of ParaView, of the files that match NAME%d.EXT, or of a list of paths,
        one after the other. Only headers are read; a step is read when it is asked for.

        The other arguments are those of Volume.open, and hold for all steps. Raises InvalidFile if steps differ in shape or type.
        """
    def __len__(self) -> int: ...
    def __getitem__(self, n: int, /) -> Volume: ...
    def __iter__(self) -> Playback: ...
    def play(self, steps: Optional[Sequence[int]] = None) -> Playback:
        """Iterates over steps in any order, by default all: each is read on another thread while the one before is in use.

        steps: numbers of steps from 0 on, for example range(0, len(sequence), 2).
        """
    def overview(self) -> Volume:
        """A Volume with the values of all steps, or of 16 from the first to the last, for transfer functions and ranges of values. It is
        not to be drawn: its voxels are a sample of those of the steps, one step after the other.
        """

@final
class Playback:
    """An iterator over steps of a VolumeSequence, which are read ahead. Made by VolumeSequence.play."""

    def __iter__(self) -> Playback: ...
    def __next__(self) -> Volume: ...

@final
class TransferFunction:
    """A piecewise linear transfer function: colour and opacity by data value.

    colors: points (value, (red, green, blue)). opacities: points (value, opacity). Both are sorted by value; colours and opacities are 0
    … 1. name: shown in messages.

    The function is constant beyond its end points. Two points at the same value make a step. Opacities are per unit distance, see
    Settings.
    """

    def __new__(
        cls,
        colors: Sequence[Tuple[float, Sequence[float]]],
        opacities: Sequence[Tuple[float, float]],
        *,
        name: str = "given",
    ) -> TransferFunction: ...
    @staticmethod
    def builtin(name: str, onto: Union[Volume, Tuple[float, float]]) -> TransferFunction:
        """A built-in colour map by name, stretched to the range of a Volume or to (lowest, highest). Names: grey, fire, viridis, cool-warm
        and others of `layersplat transfer --list`; append _r to reverse.
        """
    @staticmethod
    def automatic(volume: Volume) -> TransferFunction:
        """A default transfer function from the volume's histogram."""
    @staticmethod
    def channel(volume: Volume, color: Point, *, ramp: bool = False) -> TransferFunction:
        """The transfer function of a channel that is drawn with others: one color (red, green, blue), 0 … 1, and an opacity that rises from
        the end of the background's noise to the 99.9th percentile of the voxels. ramp: colours rise from black too, for the blend modes
        maximum, minimum and average.
        """
    @staticmethod
    def open(source: Path, volume: Volume) -> TransferFunction:
        """A built-in transfer function by name, or a ParaView colour map: FILE or FILE#PRESET."""
    def stretched(self, lo: float, hi: float) -> TransferFunction:
        """A copy, mapped linearly to the range lo … hi."""
    def faded(self, factor: float) -> TransferFunction:
        """A copy with opacities multiplied by a factor, 0 … 1."""
    def color(self, value: float) -> Point:
        """Colour (red, green, blue), 0 … 1, at a value."""
    def opacity(self, value: float) -> float:
        """Opacity per unit distance, 0 … 1, at a value."""
    @property
    def colors(self) -> Sequence[Tuple[float, Point]]:
        """Points (value, (red, green, blue)), ascending."""
    @property
    def opacities(self) -> Sequence[Tuple[float, float]]:
        """Points (value, opacity), ascending."""
    @property
    def range(self) -> Tuple[float, float]:
        """Values of the first and the last point."""
    @property
    def name(self) -> str:
        """The name shown in messages."""
    def __eq__(self, other: object, /) -> bool: ...

@final
class Settings:
    """Render settings.

    Defaults are those of the command: quality standard, composited, shaded, without clipping.

    quality: draft, standard, high or paper. algorithm: layered, axis-sheets, view-sheets, slicing or raycast. kernel: cubic, linear,
    catmull-rom or bspline; raycast also supports gaussian. Only for layered: samples_per_layer, 1 to 8; density, samples per voxel, 1 to
    16; layer_axis, auto, x, y or z. step: for slicing and raycast, in units of the smallest spacing. sheet_distance: for view-sheets,
    0.125 to 4 voxels. blend: composite, maximum, minimum, average or ('iso', value). shading: True, False, or a dict of ambient,
    ambient_color (red, green, blue), diffuse, specular, power and light. A light is a direction (x, y, z) towards it, None for a light
    at the camera, (direction, strength), (direction, strength, angle) with an angular diameter of 0 to 45 degrees, which softens
    shadows, or (direction, strength, angle, (red, green, blue)); light is one of these, or a list of up to four. Colours are from 0 to
    1. light_space: world, or camera, where directions of lights are (right, up, towards the viewer). shadows: True, False, their share,
    0 to 1, or a dict of strength, which is that share, and forgiveness, 1 to 1000: the factor of the light in shadows, by default 4.
    With shadows and without a light, the light is (-1, 1, 1) in camera space. ambient_occlusion: True, False, or a dict of reach, the
    world distance over which it decreases to 1/e, by default without limit, and gain, 1 to 1000: the factor of the ambient light, by
    default 3. light_grid: full, half or quarter, the resolution of shadows, ambient occlusion and scattered light; shadows have at least
    half. look: plain, or studio, where a sky and lights shine into the volume, which scatters their light, in linear colours; it has
    lights of its own if none are given, and of shading only specular and power count. sky: of the studio, one colour (red, green, blue),
    the colours above and below, or a dict of top, bottom, strength, up and space; linear, 0 to 100. scattering: the factor, 0 to 1, of
    the light that scatters again. exposure: stops, -20 to 20, and tone: shoulder or none, the curve of bright colours; both of 8-bit
    pictures of the studio. gradient: central, sobel, gaussian:SIGMA (0.3 to 2 voxels) or own, for layered and raycast; by default sobel
    for layered, central for quality paper, and for raycast the one that fits the kernel most closely. gradient_opacity: up to eight
    points (magnitude, factor): the opacity factor at a gradient magnitude in values per world unit. depth_cue: the share, 0 to 1, of
    black that colours fade to at the back of the volume's bounding box, or (share, (red, green, blue)) for another background. crop:
    ((x, y, z), (x, y, z)), the lowest and the highest visible voxel. planes: up to six clipping planes (point, normal) in world
    coordinates; the side that the normal points to is shown. unit_distance: thickness in world units at which the opacities apply, by
    default the smallest spacing. extinction: exponential or linear. early_termination: whether rays stop at a transmittance below
    1/4096. gamma: that of 8-bit pictures, 0.2 to 5: their colours are raised to 1/gamma. pixel_aspect: width of a pixel in heights of a
    pixel, 1/16 to 16; cameras that frame a volume take pixels as square.
    """

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
        look: Literal["plain", "studio"] = "plain",
        sky: Optional[Union[Vector, Tuple[Vector, Vector], Sky]] = None,
        scattering: Optional[float] = None,
        exposure: Optional[float] = None,
        tone: Optional[Literal["none", "shoulder"]] = None,
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
        gamma: float = 1.0,
        pixel_aspect: float = 1.0,
    ) -> Settings: ...
    def __eq__(self, other: object, /) -> bool: ...

@final
class Camera:
    """A camera in world coordinates (x, y, z).

    position: the eye; a parallel view uses only its direction. focal_point: the point at the centre of the picture. view_up: any vector
    that points up on the screen. Exactly one of: scale, half the picture's height in world units, for a parallel view; field_of_view,
    the vertical angle between 0 and 180 degrees, for a perspective.

    Raises InvalidValue if there is no valid view.
    """

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
    ) -> Camera:
        """A camera at a distance from a centre, looking at it. Angles in degrees: azimuth about y, 0 looks along −z; elevation above the xz
        plane; roll about the view direction.
        """
    @property
    def position(self) -> Point:
        """The eye."""
    @property
    def focal_point(self) -> Point:
        """The point at the centre of the picture."""
    @property
    def view_up(self) -> Point:
        """A vector that points up on the screen."""
    @property
    def scale(self) -> Optional[float]:
        """Half the picture's height in world units; None for a perspective."""
    @property
    def field_of_view(self) -> Optional[float]:
        """Vertical field of view in degrees; None for a parallel view."""
    def __eq__(self, other: object, /) -> bool: ...

@final
class Framing:
    """The outline of the visible part of a volume, to which cameras are fitted."""

    @staticmethod
    def of(volume: Volume, transfer: TransferFunction, settings: Optional[Settings] = None) -> Framing:
        """The framing of what these settings show: voxels that the transfer function makes visible, the iso-surface, or all voxels, each
        restricted to the crop box. Scans all voxels.
        """
    @staticmethod
    def whole(volume: Volume) -> Framing:
        """The framing of the whole volume."""
    def joined(self, other: Framing) -> Framing:
        """The framing of both, such as two channels."""
    @property
    def centre(self) -> Point:
        """World position (x, y, z) of its centre."""
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
    ) -> Camera:
        """A camera that fits the framing with a small margin. zoom: magnification relative to the fit.

        size: (width, height) in pixels, or one number for both. azimuth, elevation, roll: degrees, see Camera.orbit. field_of_view: the
        vertical angle of a perspective in degrees. centre: the world point at the centre of the picture.
        """

@final
class Slice:
    """A rectangle of a plane through a volume, in world coordinates (x, y, z). Drawn by Renderer.slice and Renderer.slice_values.

    centre: the point at the centre of the picture. right: direction that points right in the picture; its length does not matter. up:
    any vector that points up in the picture. scale: half the picture's height in world units.

    Raises InvalidValue if these span no plane.
    """

    def __new__(cls, centre: Vector, right: Vector, up: Vector, scale: float) -> Slice: ...
    @staticmethod
    def at(
        of: Union[Volume, DeviceVolume, Renderer],
        size: Size,
        axis: Optional[str] = None,
        at: Optional[float] = None,
        *,
        point: Optional[Vector] = None,
    ) -> Slice:
        """The slice perpendicular to an axis; it shows the whole volume.

        of: a Volume, DeviceVolume or Renderer. size: (width, height) of the picture in pixels, or one number for both. axis: x, y or z,
        seen along that axis of the voxels, or axial, coronal or sagittal, if the volume states how the patient lies; by default axial if
        it does, else z. at: number of a slice of voxels along x, y or z, from 0, or any number between two; otherwise the world
        coordinate along the axis; by default the middle. point: a world point in the slice and at the centre of the picture, instead of
        at.
        """
    @staticmethod
    def facing(
        of: Union[Volume, DeviceVolume, Renderer], size: Size, point: Vector, normal: Vector, up: Vector = (0.0, 1.0, 0.0)
    ) -> Slice:
        """The slice through a world point that is seen from where normal points; up points up as far as possible. It shows the whole
        section through the volume. of, size: see at.
        """
    @property
    def centre(self) -> Point:
        """The point at the centre of the picture."""
    @property
    def right(self) -> Point:
        """Direction that points right in the picture."""
    @property
    def up(self) -> Point:
        """A vector that points up in the picture."""
    @property
    def scale(self) -> float:
        """Half the picture's height in world units."""
    def __eq__(self, other: object, /) -> bool: ...

@final
class Device:
    """An OpenCL device with a context and a queue.

    name: index of the device to open, or part of its name. Alternatively context, device and queue of the caller, as objects with
    int_ptr (pyopencl) or integer handles. They are retained, and released with the last renderer. A queue alone is enough. In a context
    without a queue, a queue is created for the first device or the given one. Without arguments: the first GPU, otherwise the CPU.

    memory: a memory budget in bytes for the buffers of all renderers of this Device. Volumes that do not fit are streamed in parts; the
    picture is identical. Streaming supports layers on a lattice. Views and settings that need all voxels at once raise OutOfMemory, and
    the message states how many bytes are enough. Renderer.enqueue and Renderer.volume_changed do not support streaming.

    Integers that are not handles of live objects crash the process.
    """

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
    def list() -> Sequence[Dict[str, Any]]:
        """All devices, one dict each: index, name, kind, platform, version, driver, compute_units, memory_bytes."""
    @property
    def name(self) -> str:
        """Device name."""
    @property
    def platform(self) -> str:
        """Platform name: the OpenCL implementation."""
    @property
    def context(self) -> int:
        """The cl_context, valid as long as this object: pyopencl.Context.from_int_ptr(device.context)."""
    @property
    def id(self) -> int:
        """The cl_device_id."""
    @property
    def queue(self) -> int:
        """The cl_command_queue, valid as long as this object."""
    @property
    def memory(self) -> Optional[int]:
        """The memory budget in bytes; None without one."""
    @property
    def allocated_bytes(self) -> int:
        """Bytes of buffers that renderers have allocated."""

@final
class DeviceVolume:
    """A volume whose voxels stay in a buffer of the caller on the device.

    The buffer is retained, and so is its Python object: a memory pool reuses a buffer when its object is gone. Both are held as long as
    this volume or one of its renderers exists.

    device: a Device of the buffer's context. buffer: an object with int_ptr (pyopencl.Buffer) or an integer handle. shape: (z, y, x).
    dtype: uint8, int8, uint16, int16 or float32. spacing: one number or (z, y, x), in world units. first: byte offset of the first
    voxel. pitches: bytes from row to row and from slice to slice. range: (smallest, largest) value, which is not checked; None: it is
    determined on the device after wait_for, and the constructor waits for it. background: the value around the volume, by default the
    smallest. name: shown in messages.

    Voxels may change between frames: call Renderer.volume_changed of every renderer.

    Raises InvalidValue if the buffer is too small, belongs to another context, or is write-only.
    """

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
    def shape(self) -> Tuple[int, int, int]:
        """Number of voxels along z, y, x."""
    @property
    def dtype(self) -> str:
        """Voxel type."""
    @property
    def spacing(self) -> Point:
        """Voxel spacing along x, y, z, in world units."""
    @property
    def centre(self) -> Point:
        """World position (x, y, z) of the centre."""
    @property
    def range(self) -> Tuple[float, float]:
        """Smallest and largest value."""

@final
class Event:
    """An OpenCL event of enqueued commands."""

    @property
    def int_ptr(self) -> int:
        """The `cl_event` handle, valid as long as this object: for `pyopencl.Event.from_int_ptr(event.int_ptr, retain=True)`."""
    def wait(self) -> None:
        """Waits until the event is complete, with the GIL released. Ctrl-C ends the wait, but not the command.

        Raises DeviceError if the command, or one in its wait list, has failed.
        """
    @property
    def is_complete(self) -> bool:
        """Whether the command is complete; False while it is queued or running.

        Raises DeviceError, with the OpenCL status, if the command has failed: it will never complete.
        """
    def to_pyopencl(self) -> Any:
        """The same event as a pyopencl.Event, with its own reference."""

@final
class LiveScene:
    """The voxels of a View on a device, shared by its renderer and its pages. Not for users.

    volume: a Volume, which is uploaded, or streamed if the device has a memory budget. transfer: the transfer function that the pages
    call the first one. device: a Device. labels: Labels in whose colours the volume is drawn, or None.
    """

    def __new__(cls, volume: Volume, transfer: TransferFunction, device: Device, labels: Optional[Labels] = None) -> LiveScene: ...
    def renderer(self, transfer: TransferFunction) -> Renderer:
        """A renderer of these voxels."""
    def show(self, settings: Settings, background: Background) -> None:
        """Shows these settings from the next picture of each page on."""
    def page(self, camera: Camera, transfer: TransferFunction, send: Callable[[Optional[str], Optional[bytes]], Any]) -> LivePage:
        """A page, to which `send(text, picture)` carries messages, one of both each. It is called at once and by the thread that draws."""

@final
class LivePage:
    """A page of a LiveScene. Not for users."""

    def receive(self, message: str, follow: bool) -> List[Tuple[str, Any]]:
        """Takes a message of the page. It does not wait for pictures. Returns what a hand changed, (name, value) each; nothing unless
        `follow`, for messages of a page that does not know the newest state yet.
        """
    def give(self, camera: Camera, transfer: TransferFunction) -> None:
        """Shows another camera and transfer function, and what the scene shows now."""
    def close(self) -> None:
        """Ends the page, and waits until its running kernel has ended."""

@final
class Channel:
    """A volume that is drawn together with others, by Renderer([channel, …]): extinctions add, and colours are weighted by them.

    volume: a Volume, or anything that Volume() takes. transfer: a TransferFunction, by default TransferFunction.channel(volume, color).
    color: (red, green, blue), 0 … 1, by default white, instead of transfer. factor: factor of the extinction, at least 0. visible:
    hidden channels cost nothing. iso: value of the iso-surface, instead of that of the settings. gradient_opacity: see Settings, which
    has that of channels without one.

    A renderer draws up to eight channels, with grids of their own. Channels made by replaced share the voxels on the device.
    """

    def __new__(
        cls,
        volume: Any,
        transfer: Optional[TransferFunction] = None,
        *,
        color: Optional[Point] = None,
        factor: float = 1.0,
        visible: bool = True,
        iso: Optional[float] = None,
        gradient_opacity: Optional[Sequence[Tuple[float, float]]] = None,
    ) -> Channel: ...
    @staticmethod
    def open(path: Path) -> List[Channel]:
        """Opens all channels of a file as a list. Colours, windows of values and hidden channels are those that the file states (OME-Zarr,
        OME-TIFF, ImageJ's TIFF); the other colours are those of channel_colors, the other windows automatic.
        """
    def replaced(
        self,
        *,
        transfer: Optional[TransferFunction] = None,
        factor: Optional[float] = None,
        visible: Optional[bool] = None,
        iso: Optional[float] = None,
        gradient_opacity: Optional[Sequence[Tuple[float, float]]] = None,
    ) -> Channel:
        """A copy with other properties; what is None stays. The copy shares the voxels on the device."""
    def framing(self, settings: Optional[Settings] = None) -> Framing:
        """The framing of what these settings show of the channel, see Framing.of. Clipping is not considered. Scans all voxels."""
    @property
    def volume(self) -> Volume:
        """The voxels."""
    @property
    def transfer(self) -> TransferFunction:
        """The transfer function."""
    @property
    def factor(self) -> float:
        """Factor of the extinction."""
    @property
    def visible(self) -> bool:
        """Whether it is drawn."""
    @property
    def iso(self) -> Optional[float]:
        """Value of its own iso-surface; None: that of the settings."""

@final
class Colors:
    """A volume of colours, drawn by Renderer(colors).

    data: an array (z, y, x, 3) or (z, y, x, 4) of uint8, uint16 or float32: red, green, blue and possibly alpha. Integers are
    intensities up to the largest number of their type; floats are 0 … 1. spacing: one number or (z, y, x), in world units. opacity:
    alpha, the fourth component, per smallest spacing; luminance; or a background colour (red, green, blue), 0 … 1, from which colours
    differ. By default alpha if there is one, else luminance. transfer: its opacities apply to luminance and to the difference from the
    background, in units of the components; by default they rise from 0 to 0.3. direction: whether data are vectors, an array (z, y, x,
    3) of the components x, y and z of any type. Their colours are (|x|, |y|, |z|) / norm, and their opacity that of transfer at the
    norm, automatic by default. Vectors that are 0 or have a component that is not a number are transparent.

    Extinction and extinction times colour are interpolated, so transparent voxels do not bleed their colour. Colours are drawn in
    point-sampled layers with the blend mode composite.
    """

    def __new__(
        cls,
        data: Any,
        spacing: Optional[Union[float, Sequence[float]]] = None,
        *,
        opacity: Optional[Union[str, Point]] = None,
        transfer: Optional[TransferFunction] = None,
        direction: bool = False,
    ) -> Colors: ...
    @staticmethod
    def open(path: Path, *, opacity: Optional[Union[str, Point]] = None, transfer: Optional[TransferFunction] = None) -> Colors:
        """Opens a file of colours: red, green, blue and possibly alpha, its first three or four channels. opacity, transfer: see Colors.
        Files of colours are PNG, TIFF (RGB), NRRD, NIfTI (RGB24, RGBA32), DICOM and VTK; any other file of three channels or more is
        drawn so, too.
        """
    def framing(self) -> Framing:
        """The framing of voxels whose alpha is above 0, otherwise of all voxels."""
    @property
    def shape(self) -> Tuple[int, int, int, int]:
        """Number of voxels along z, y, x, and of components."""

@final
class Labels:
    """A volume of labels, drawn by Renderer(labels): surfaces in the colours of a table. Ids are never mixed.

    data: an array (z, y, x) of ids, whole numbers from 0, the background, to 2³² − 1, with at most 65535 different ones; or an image
    object, see Volume. table: a dict from ids to a name, a colour (#rrggbb, or red, green, blue and possibly opacity, 0 … 1), or a dict
    with any of name, color, opacity and visible; or a file: look-up tables of FreeSurfer, ITK-SNAP and 3D Slicer, or JSON. Ids without
    an entry are opaque, in a colour that depends on the id. changes: texts such as 3,7-9:#ff0000:0.4 or liver:only, which change the
    table: colour, opacity, and show, hide, only or highlight. spacing: one number, or one per axis of the data. surfaces: smooth, or
    voxels for those of the voxels.

    Labels are drawn in point-sampled layers with the blend mode composite. Renderer.set_label_colors draws a volume in their colours.
    """

    def __new__(
        cls,
        data: Any,
        table: Any = None,
        spacing: Optional[Union[float, Sequence[float]]] = None,
        *,
        changes: Optional[Sequence[str]] = None,
        surfaces: Literal["smooth", "voxels"] = "smooth",
    ) -> Labels: ...
    @staticmethod
    def open(
        path: Path,
        table: Any = None,
        *,
        changes: Optional[Sequence[str]] = None,
        surfaces: Literal["smooth", "voxels"] = "smooth",
    ) -> Labels:
        """Opens a file: .seg.nrrd, also with segments that overlap, NIfTI, OME-Zarr, or any volume of whole numbers. Names and colours come
        from table, otherwise from the volume's own metadata. table, changes and surfaces: see Labels.
        """
    def changed(self, changes: Sequence[str]) -> Labels:
        """A copy after further changes, see Labels. It shares the voxels."""
    def framing(self) -> Framing:
        """The framing of the visible labels. Scans all voxels."""
    @property
    def table(self) -> Dict[int, Dict[str, Any]]:
        """The labels that voxels have: a dict from ids to dicts of name, color, opacity and visible. It can be changed, and given to
        Labels.
        """
    @property
    def shape(self) -> Tuple[int, int, int]:
        """Number of voxels along z, y, x."""

def channel_colors(names: Sequence[Optional[str]]) -> List[Point]:
    """Colours (red, green, blue) of channels that have these names, or None. A fluorophore in a name has its usual colour (DAPI is blue);
    others get well separated ones, also for the colour-blind: green, magenta, cyan, yellow, red, blue. A single channel is white.
    """

@disjoint_base
class Surface:
    """A Mesh, Spheres or Tubes: surfaces that Renderer.set_surfaces and render draw in and around a volume. World coordinates are (x, y,
    z).

    These keywords of Mesh, Spheres, Tubes and replaced say how it looks. color: `#rrggbb` or (red, green, blue), 0 … 1, possibly with
    alpha; by default light grey. opacity: 0 … 1, multiplies the alpha of colors. matrix: an array of 4 x 4 numbers that places it in the
    world; spheres and tubes are not deformed. shading: smooth, which needs normals, flat or off. clip: whether the crop box and clip
    planes cut it. visible: whether it is drawn. name: shown in messages.
    """

    def __new__(cls, surface: Surface) -> Self: ...
    @staticmethod
    def _triangles(vertices: NDArray[np.float64], faces: NDArray[np.uint32], normals: Optional[NDArray[np.float32]]) -> Surface: ...
    @staticmethod
    def _spheres(centres: NDArray[np.float64], radius: Optional[NDArray[np.float64]]) -> Surface: ...
    @staticmethod
    def _tubes(vertices: NDArray[np.float64], lengths: List[int], radius: Optional[NDArray[np.float64]], ends: str) -> Surface: ...
    def _colored(self, colors: NDArray[np.float32], of_cells: bool) -> Surface: ...
    def _valued(self, values: NDArray[np.float32], of_cells: bool, transfer: Optional[Union[TransferFunction, str]]) -> Surface: ...
    @staticmethod
    def open(
        path: Path,
        *,
        data: Optional[Path] = None,
        values: Optional[str] = None,
        transfer: Optional[Union[TransferFunction, str]] = None,
        radius: Optional[Union[float, str]] = None,
        ends: Literal["flat", "open", "round"] = "flat",
        space: Optional[Literal["LPS", "RAS"]] = None,
        volume: Optional[Volume] = None,
    ) -> List[Surface]:
        """Opens a file: STL, PLY, OBJ, VTK PolyData, GIFTI or FreeSurfer, as a list: triangles as a Mesh, lines as Tubes, single points as
        Spheres, each if the file has them.

        data: a file of GIFTI or FreeSurfer with values or labels of the points, of which labels, else the first values, are shown.
        values: name of an array whose values are shown as colours. transfer: a TransferFunction or the name of a colour map, by default
        viridis over all values. radius: of tubes and spheres, a number or the name of an array of points; by default 1/200 of the
        diagonal of the bounds. ends: flat, open or round, of tubes. space: LPS or RAS, the axes of a patient, if the file states none.
        volume: a Volume; where it is a patient's, as those of NIfTI and DICOM files, coordinates that are known to be LPS are turned
        into its world.
        """
    def replaced(
        self,
        *,
        color: Any = None,
        opacity: Optional[float] = None,
        matrix: Any = None,
        shading: Optional[Literal["smooth", "flat", "off"]] = None,
        clip: Optional[bool] = None,
        visible: Optional[bool] = None,
        name: Optional[str] = None,
    ) -> Self:
        """A copy that looks otherwise; what is None stays. It shares the points. Keywords: see Surface."""
    def framing(self) -> Optional[Framing]:
        """The framing of its bounds, see Framing.joined; None if it has no points."""
    @property
    def bounds(self) -> Optional[Tuple[Point, Point]]:
        """The lowest and the highest corner, (x, y, z) each, of its bounds in the world; None if it has no points."""
    @property
    def points(self) -> int:
        """Number of points: vertices, centres, or points of lines."""
    @property
    def cells(self) -> int:
        """Number of cells: triangles, spheres or lines."""
    @property
    def color(self) -> Point:
        """Colour (red, green, blue), 0 … 1, where it has no colors and values."""
    @property
    def opacity(self) -> float:
        """Opacity, 0 … 1."""
    @property
    def visible(self) -> bool:
        """Whether it is drawn."""
    @property
    def name(self) -> str:
        """The name shown in messages."""

@final
class Renderer:
    """A renderer of one volume on one device. Threads may share it.

    volume: a Volume, or anything that Volume() takes, is uploaded. A DeviceVolume or a pyopencl.array.Array (z, y, x) is rendered in
    place. transfer: a TransferFunction; by default one from the histogram, for voxels on the host. device: a Device, its name or index;
    or the caller's context, device and queue, see Device. time_limit: time limit per frame in seconds; None: no limit. Instead of a
    volume, a list of Channel, Colors and Labels is drawn together, and a Colors or a Labels by itself; they have their own colours, so
    transfer is left out.

    If the Device has a memory budget, or the volume exceeds its largest buffer, the voxels are uploaded during frames, in parts if they
    do not fit. The renderer then keeps the Volume. See stream_plan.

    On Python's main thread, Ctrl-C interrupts the constructor, render, render_float, depths, slice, slice_values and prepare:
    KeyboardInterrupt is raised immediately. The kernel that is running completes first; the next call waits for it.
    """

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
    ) -> NDArray[np.uint8]:
        """Renders a picture: (height, width, 4), uint8, over a background; row 0 on top. With a transparent background, alpha is straight."""
    def render_float(self, camera: Camera, size: Size, settings: Optional[Settings] = None) -> NDArray[np.float32]:
        """Renders a picture: (height, width, 4), float32, premultiplied, 0 … 1, without a background; row 0 on top."""
    def depths(
        self, camera: Camera, size: Size, settings: Optional[Settings] = None
    ) -> Tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Renders two depth maps (height, width), float32: the first visible depth, and the mean depth weighted by opacity. Depths are
        distances from the eye along the view direction, in world units; infinite where nothing is visible.

        Depths are always computed by ray casting. Raises InvalidValue for blend modes other than composite and iso.
        """
    def slice(
        self,
        slice: Slice,
        size: Size,
        *,
        kernel: str = "linear",
        window: Optional[Tuple[float, float]] = None,
        thickness: Optional[float] = None,
        background: Background = "black",
    ) -> NDArray[np.uint8]:
        """Draws a slice: (height, width, 4), uint8, over a background; row 0 on top. Where the slice lies outside the volume, the
        background shows.

        kernel: linear, cubic, catmull-rom, bspline or gaussian. window: (level, width) of a window of grey; otherwise the colours of the
        transfer function, opaque wherever it has any opacity. thickness: gives colours the opacity of a layer this many unit distances
        thick.
        """
    def slice_values(self, slice: Slice, size: Size, *, kernel: str = "linear") -> NDArray[np.float32]:
        """The data values of a slice: (height, width), float32, NaN outside the volume. kernel: see slice."""
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
    ) -> Event:
        """Enqueues a picture into a buffer or a 2D image of the context, after wait_for. Returns an Event without waiting.

        onto: an object with int_ptr (pyopencl) or an integer handle. format: rgba8, over the background, or float, premultiplied,
        without a background. first: byte offset of the first pixel in a buffer. row_pitch: bytes from row to row. wait_for: Events,
        objects with int_ptr or integer handles.

        Raises InvalidValue for sheet algorithms, which need host readback, for hundreds of translucent surfaces behind each other, and
        if the picture does not fit. The queue stays usable.
        """
    def prepare(self, camera: Camera, size: Size, settings: Optional[Settings] = None) -> None:
        """Builds the kernels, tables and layouts that pictures with these settings need, for every view direction, and waits for them."""
    def volume_changed(self, wait_for: Optional[Sequence[Union[Event, Handle]]] = None) -> Event:
        """Notifies the renderer that voxels in the caller's memory change, and are valid after wait_for. Returns an Event; frames wait for
        it automatically.
        """
    def cancel(self) -> None:
        """Cancels calls of render, render_float, depths, slice, slice_values and prepare on other threads, including those that wait for
        the renderer. They raise Cancelled before their next kernel. Later calls are not affected. Does not block.
        """
    def set_volume(self, volume: Any) -> None:
        """Replaces the volume, from the next frame on: a Volume, or anything that Volume() takes. Shape, type and range may differ. A list
        of Channel, Colors and Labels, a Colors or a Labels replaces all that is drawn; voxels that are on the device stay there.

        Raises InvalidType for voxels on a device (a DeviceVolume or a pyopencl.array.Array): they need a new Renderer. Raises
        OutOfMemory if device memory is insufficient; the renderer may then have no volume until one is set.
        """
    def set_label_colors(self, labels: Optional[Labels]) -> None:
        """Draws the volume in the colours of labels from the next frame on, or in its own again: labels is None. Its opacities stay. The
        colour C of the volume becomes (1 - w) C + w L where a label has the colour L and the opacity w, before lighting; hidden labels
        leave it. Labels without a placement, as arrays, lie where a volume of their shape does.

        Point-sampled layers and ray casting have them, with the blend modes composite and iso; other frames, slices, and frames of
        channels, Colors or Labels raise InvalidValue. So do labels that lie outside the volume, and renderers that stream.
        """
    def set_surfaces(self, surfaces: Sequence[Surface]) -> None:
        """Draws surfaces in and around the volume, from the next frame on, in place of those before: a list of Mesh, Spheres and Tubes.

        Slices show none. Splatted layers, sheets and slicing raise InvalidValue while there are visible ones.
        """
    def stream_plan(self, camera: Camera, size: Size, settings: Optional[Settings] = None) -> Optional[Dict[str, Any]]:
        """The streaming plan of a view, a dict; None if the renderer holds all voxels.

        lattices: a list of dicts with the layer axis, the number of parts that are uploaded in sequence, and held_layers, the maximum
        number of layers on the device. voxel_bytes: bytes of voxels that a frame uploads. light_bytes: bytes of those that it uploads
        before, for shadows and ambient occlusion; 0 if these are kept from an earlier frame. volume_bytes: bytes of all voxels.
        device_bytes: peak bytes of buffers. available_bytes: bytes available for these buffers.

        Raises OutOfMemory if the budget is too small for the view.
        """
    @property
    def time_limit(self) -> Optional[float]:
        """Time limit per frame in seconds; None: no limit. A frame that exceeds it raises TimedOut before its next kernel. It can be set,
        effective from the next frame. Enqueued frames are not limited.
        """
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
    ) -> Camera:
        """A camera that shows the whole grid from all sides. zoom: magnification relative to the fit.

        size: (width, height) in pixels, or one number for both. azimuth, elevation, roll: degrees, see Camera.orbit. field_of_view: the
        vertical angle of a perspective in degrees.
        """
    @property
    def transfer(self) -> TransferFunction:
        """The transfer function. It can be set, effective from the next frame."""
    @transfer.setter
    def transfer(self, transfer: TransferFunction) -> None: ...
