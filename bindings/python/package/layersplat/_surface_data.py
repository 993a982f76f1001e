"""What arrays and objects of other packages hold of surfaces. Objects are recognised by their attributes: none of these packages is imported."""

from typing import Any, Dict, Iterable, List, NamedTuple, Optional, Tuple

import numpy as np

from ._checks import accepting, warn
from ._errors import InvalidType, InvalidValue

POLYDATA = ("points", "faces", "lines", "verts", "point_data", "cell_data")
MESHIO = ("points", "cells_dict", "point_data", "cell_data_dict")
TRIMESH = ("vertices", "faces", "vertex_normals")
POINT_CLOUD = ("vertices", "colors")
"""Attributes by which objects are recognised: of pyvista, meshio and trimesh."""


class Data(NamedTuple):
    """What an object holds."""

    name: str
    """For messages."""
    points: np.ndarray
    triangles: np.ndarray = np.empty((0, 3), np.uint32)
    triangle_cells: np.ndarray = np.empty(0, np.intp)
    """Which entry of arrays of cells is theirs."""
    lines: List[np.ndarray] = []
    line_cells: np.ndarray = np.empty(0, np.intp)
    cells: int = 0
    """Entries of arrays of cells."""
    normals: Optional[np.ndarray] = None
    colors: Any = None
    values: Any = None
    """Shown unless others are given."""
    point_arrays: Dict[str, Any] = {}
    cell_arrays: Dict[str, Any] = {}

    def with_polygons(self, polygons: Iterable[Tuple[np.ndarray, np.ndarray]]) -> "Data":
        """With the triangles of polygons as fans: arrays (m, k) of corners, and their numbers among these polygons."""
        parts, cells, count = [self.triangles], [self.triangle_cells], self.cells
        for corners, numbers in polygons:
            for second in range(1, corners.shape[1] - 1):
                parts.append(corners[:, [0, second, second + 1]])
                cells.append(self.cells + numbers)
            count += len(corners)
        triangles, owners = np.concatenate(parts), np.concatenate(cells)
        order = np.argsort(owners, kind="stable")
        triangles = np.require(_checked("faces", triangles[order], len(self.points)), np.uint32, "C")
        return self._replace(triangles=triangles, triangle_cells=owners[order], cells=count)

    def with_lines(self, lines: List[np.ndarray]) -> "Data":
        """With lines, arrays of indices."""
        lines = [_checked("lines", line, len(self.points)) for line in lines]
        return self._replace(lines=lines, line_cells=np.arange(self.cells, self.cells + len(lines)), cells=self.cells + len(lines))


def points_of(name, given):
    """Vectors (n, 3), contiguous."""
    with accepting(name, given, "an array (n, 3) of x, y and z, or an object of pyvista, trimesh or meshio"):
        points = np.require(np.asarray(given, dtype=float), float, "C")
    if points.ndim != 2 or points.shape[1] != 3:
        raise InvalidValue(f"{name} has the shape {points.shape}: give (n, 3), x, y and z of each")
    return points


def _checked(name, indices, count):
    if len(indices) and (indices.min() < 0 or indices.max() >= count):
        wrong = indices.min() if indices.min() < 0 else indices.max()
        raise InvalidValue(f"{name} has the index {wrong}, and there are {count} vertices: indices count from 0")
    return indices


def polygons_of(name, faces):
    """The polygons of an argument, see ``with_polygons``."""
    with accepting(name, faces, "an array (m, 3) of indices"):
        found = np.asarray(faces)
    if found.size == 0:
        return []
    if found.dtype.kind not in "iu":
        raise InvalidValue(f"{name} is of type {found.dtype}: give whole numbers, the indices of vertices")
    if found.ndim == 1:
        starts, counts = _row(name, found)
        chosen = [(count, np.flatnonzero(counts == count)) for count in np.unique(counts)]
        return [(found[starts[numbers, None] + np.arange(count)], numbers) for count, numbers in chosen]
    if found.ndim == 2 and found.shape[1] >= 3:
        return [(found, np.arange(len(found)))]
    raise InvalidValue(f"{name} has the shape {found.shape}: give (m, 3), the indices of three vertices each")


def _row(name, row):
    """Where cells begin, and their numbers of points, in one row that has both, as VTK has it: the number before the indices of each."""
    size = int(row[0]) + 1 if len(row) else 1
    if size > 0 and len(row) % size == 0 and (row[::size] == row[:1]).all():
        return np.arange(1, len(row), size), np.full(len(row) // size, size - 1)
    starts, at = [], 0
    while at < len(row):
        starts.append(at + 1)
        if row[at] < 0 or at + row[at] >= len(row):
            raise InvalidValue(f"{name} ends within a cell of {row[at]} points: in one row, the number of points of each cell is first")
        at += int(row[at]) + 1
    starts = np.asarray(starts)
    return starts, row[starts - 1]


def of_lines(points):
    """Data of one line, or of a list of lines."""
    is_list = isinstance(points, (list, tuple)) or not hasattr(points, "dtype") and hasattr(points, "__len__")
    if not is_list or (len(points) and np.ndim(points[0]) == 1):
        points = [points]
    parts = [points_of("points", line) for line in points]
    ends = np.cumsum([len(line) for line in parts], dtype=np.intp)
    data = Data("points", np.concatenate(parts) if parts else np.empty((0, 3)))
    return data.with_lines([np.arange(end - len(line), end) for line, end in zip(parts, ends)])


def recognised(name, given) -> Optional[Data]:
    """What an object of another package holds; None for arrays."""
    if _has(given, POLYDATA):
        return _polydata(given)
    if hasattr(given, "extract_surface"):
        raise InvalidType(f"{name} is a {type(given).__name__}: give its surface, {name}.extract_surface()")
    if hasattr(given, "GetPolys"):
        raise InvalidType(f"{name} is a {type(given).__name__} of VTK: give pyvista.wrap({name})")
    if _has(given, MESHIO):
        return _meshio(given)
    if _has(given, TRIMESH):
        return _trimesh(given)
    if _has(given, POINT_CLOUD):
        return Data(type(given).__name__, points_of(name, given.vertices), colors=_nonempty(given.colors))
    is_pair = isinstance(given, tuple) and len(given) in (2, 3) and all(np.ndim(part) == 2 for part in given[:2])
    if name == "vertices" and is_pair:
        return _napari(*given)
    return None


def _has(given, names):
    return all(hasattr(given, name) for name in names)


def _nonempty(array):
    return array if array is not None and len(array) else None


def _polydata(given):
    """A pyvista.PolyData. Arrays of cells are in the order of vertices, lines, faces and strips."""
    name = type(given).__name__
    if len(getattr(given, "strips", ())):
        raise InvalidValue(f"{name} has strips: give its triangles, triangulate()")
    arrays, lines = dict(given.point_data.items()), np.asarray(given.lines)
    data = Data(
        name,
        points_of("points", given.points),
        cells=len(_row("verts", np.asarray(given.verts))[0]),
        normals=arrays.get("Normals"),
        point_arrays=arrays,
        cell_arrays=dict(given.cell_data.items()),
    )
    data = data.with_lines([lines[start : start + count] for start, count in zip(*_row("lines", lines))])
    return data.with_polygons(polygons_of("faces", given.faces))


def _meshio(given):
    """A meshio.Mesh: cells, and their arrays, by kind."""
    name, points, cells = "the Mesh of meshio", np.asarray(given.points), given.cells_dict
    kinds = [kind for kind in cells if kind in ("line", "triangle", "quad", "polygon")]
    if cells and not kinds and "vertex" not in cells:
        raise InvalidValue(f"{name} has cells of the kind {', '.join(cells)}: give one with its surface as triangles")
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    arrays = {key: of for key, of in given.cell_data_dict.items() if kinds and all(kind in of for kind in kinds)}
    joined = {key: np.concatenate([of[kind] for kind in kinds]) for key, of in arrays.items()}
    data = Data(name, points_of("points", points), point_arrays=dict(given.point_data), cell_arrays=joined)
    for kind in kinds:
        corners = np.asarray(cells[kind])
        if kind == "line":
            # A polyline is written as its pieces, which are joined unless they have values of their own.
            breaks = np.arange(1, len(corners)) if joined else 1 + np.flatnonzero(corners[1:, 0] != corners[:-1, 1])
            data = data.with_lines([np.append(part[:1, 0], part[:, 1]) for part in np.split(corners, breaks)])
        else:
            data = data.with_polygons([(corners, np.arange(len(corners)))])
    return data


def _trimesh(given):
    """A trimesh.Trimesh, in its colours."""
    visual = getattr(given, "visual", None)
    kind = getattr(visual, "kind", None)
    if kind == "texture":
        warn("textures are not drawn: trimesh's visual.to_color() makes colours of one")
    colors = {"vertex": "vertex_colors", "face": "face_colors"}.get(kind)
    data = Data(
        type(given).__name__,
        points_of("vertices", given.vertices),
        normals=np.asarray(given.vertex_normals),
        colors=None if colors is None else np.asarray(getattr(visual, colors)),
        point_arrays=dict(getattr(given, "vertex_attributes", {})),
        cell_arrays=dict(getattr(given, "face_attributes", {})),
    )
    return data.with_polygons(polygons_of("faces", given.faces))


def _napari(vertices, faces, values=None):
    """The data of a surface layer of napari: vertices in the order of an array's axes, z, y, x."""
    data = Data("the tuple", points_of("vertices", np.asarray(vertices, dtype=float)[:, ::-1]), values=values)
    return data.with_polygons(polygons_of("faces", faces))
