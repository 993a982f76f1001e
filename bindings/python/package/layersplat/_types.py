"""What arguments can be: for type checkers, and for whom annotates with them."""

from os import PathLike
from typing import Any, Literal, Optional, Protocol, Sequence, Tuple, TypedDict, Union

import numpy as np
from numpy.typing import NDArray

Size = Union[int, Tuple[int, int]]
"""(width, height) in pixels, or one number of both."""
Vector = Union[Sequence[float], NDArray[np.floating[Any]]]
"""(x, y, z)."""
Point = Tuple[float, float, float]
Background = Union[str, Tuple[float, float, float]]
"""transparent, black, white, grey, #rrggbb, or (red, green, blue), 0 … 1."""
Quality = Literal["draft", "standard", "high", "paper"]
Blend = Union[Literal["composite", "maximum", "minimum", "average"], Tuple[Literal["iso"], float]]
Path = Union[str, "PathLike[str]"]


class HasHandle(Protocol):
    """An OpenCL object of another package, pyopencl for instance."""

    @property
    def int_ptr(self) -> int:
        """The handle."""
        ...


Handle = Union[HasHandle, int]


Light = Union[None, Vector, Tuple[Optional[Vector], float]]
"""A white light: the direction to it in the world, or None: at the camera; and its strength, where that is not 1."""


class Shading(TypedDict, total=False):
    """How what is seen is lit; what is left out keeps its default. light: one, or up to four."""

    ambient: float
    diffuse: float
    specular: float
    power: float
    light: Union[Light, Sequence[Light]]
