"""Types of arguments, for type checkers and annotations."""

from os import PathLike
from typing import Any, Literal, Optional, Protocol, Sequence, Tuple, TypedDict, Union

import numpy as np
from numpy.typing import NDArray

Size = Union[int, Tuple[int, int]]
"""(width, height) in pixels, or one number for both."""
Vector = Union[Sequence[float], NDArray[np.floating[Any]]]
"""(x, y, z)."""
Point = Tuple[float, float, float]
Background = Union[str, Tuple[float, float, float]]
"""transparent, black, white, grey, #rrggbb, or (red, green, blue), 0 … 1."""
Quality = Literal["draft", "standard", "high", "paper"]
Blend = Union[Literal["composite", "maximum", "minimum", "average"], Tuple[Literal["iso"], float]]
Path = Union[str, "PathLike[str]"]


class HasHandle(Protocol):
    """An OpenCL object of another package, for example pyopencl."""

    @property
    def int_ptr(self) -> int:
        """The handle."""
        ...


Handle = Union[HasHandle, int]


Light = Union[
    None,
    Vector,
    Tuple[Optional[Vector], float],
    Tuple[Optional[Vector], float, float],
    Tuple[Optional[Vector], float, float, Vector],
]
"""A light: the direction towards it, or None for a light at the camera; optionally with its strength, by default 1, its angular diameter in
degrees, by default 0, and its colour, by default white: red, green and blue from 0 to 1."""


class Shading(TypedDict, total=False):
    """Shading coefficients. Missing ones keep their defaults. light: one light, or a list of up to four."""

    ambient: float
    ambient_color: Vector
    diffuse: float
    specular: float
    power: float
    light: Union[Light, Sequence[Light]]


class Shadows(TypedDict, total=False):
    """Coefficients of shadows. Missing ones keep their defaults."""

    strength: float
    forgiveness: float


class Sky(TypedDict, total=False):
    """The sky of the look studio."""

    top: Tuple[float, float, float]
    bottom: Tuple[float, float, float]
    strength: float
    up: Tuple[float, float, float]
    space: Literal["world", "camera"]


class AmbientOcclusion(TypedDict, total=False):
    """Coefficients of ambient occlusion. Missing ones keep their defaults."""

    reach: float
    gain: float
