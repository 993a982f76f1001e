"""Surfaces from arrays and from objects of other packages, which are recognised by their attributes: none of these packages is imported."""

from typing import Any, Dict, Iterable, List, NamedTuple, Optional, Tuple

import numpy as np

from ._checks import accepting, warn
from ._errors import InvalidType, InvalidValue
from ._layersplat import Framing, Surface
from ._transfer import _color

POLYDATA = ("points", "faces", "lines", "verts", "point_data", "cell_data")
MESHIO = ("points", "cells_dict", "point_data", "cell_data_dict")
TRIMESH = ("vertices", "faces", "vertex_normals")
POINT_CLOUD = ("vertices", "colors")
"""Attributes by which objects are recognised: of pyvista, meshio and trimesh."""

LARGEST_INDEX = 2**32 - 1


class Mesh(Surface):
    """Triangles, also those of polygons. World coordinates are (x, y, z).

    vertices: an array (n, 3); or, without faces, an object that has both: a ``pyvista.PolyData``, ``trimesh.Trimesh`` or ``meshio.Mesh``,
    or a tuple (vertices, faces[, values]) of napari, whose vertices are in the order of an array's axes, (z, y, x). faces: an array (m, 3)
    of indices that count from 0, (m, k) for polygons, or numbers of corners and indices in one row, as pyvista has them. normals: an array
    (n, 3), for smooth shading. colors: an array (n, 3), (n, 4), (m, 3) or (m, 4) per vertex or face, uint8 or floats from 0 to 1. values:
    numbers per vertex or face, which transfer shows as colours: a TransferFunction, or the name of a colour map, by default viridis over
    all values. colors and values may also be names of arrays of the object. look: color, opacity and others, see Surface.

    Normals of an object are used. So are colours of a trimesh, and values of a tuple, unless others are given.
    """

    def __new__(
        cls, vertices: Any, faces: Any = None, *, normals: Any = None, colors: Any = None, values: Any = None, transfer: Any = None, **look: Any
    ) -> "Mesh":
        data = _recognised("vertices", vertices)
        if data is None:
            data = Data("faces", _points("vertices", vertices))
            if faces is None:
                raise InvalidValue("faces is missing: give an array (m, 3) of indices, or an object that has vertices and faces")
            data = data.with_polygons(_polygons("faces", faces))
        elif faces is not None:
            raise InvalidValue(f"faces: leave it out, vertices is a {type(vertices).__name__}, which has its own")
        if not len(data.triangles):
            raise InvalidValue(f"{data.name} has no faces: its points are drawn by Spheres, and its lines by Tubes")
        normals = data.normals if normals is None else _points("normals", normals)
        if normals is not None and len(normals) != len(data.points):
            raise InvalidValue(f"normals has {len(normals)} entries for {len(data.points)} vertices: give one each")
        made = Surface._triangles(data.points, data.triangles, None if normals is None else np.require(normals, np.float32, "C"))
        return _finished(cls, made, data, data.triangle_cells, colors, values, transfer, look)


class Spheres(Surface):
    """Spheres. World coordinates are (x, y, z).

    centres: an array (n, 3); or an object whose points they are, see Mesh. radius: one number, an array of n, or the name of an array of
    points; by default 1/200 of the diagonal of their bounds. colors, values: per centre, or the name of an array of the object's points.
    transfer, look: see Mesh.
    """

    def __new__(cls, centres: Any, radius: Any = None, *, colors: Any = None, values: Any = None, transfer: Any = None, **look: Any) -> "Spheres":
        data = _recognised("centres", centres) or Data("centres", _points("centres", centres))
        made = Surface._spheres(data.points, _radii(radius, data))
        return _finished(cls, made, data, None, colors, values, transfer, look)


class Tubes(Surface):
    """Tubes around lines. World coordinates are (x, y, z).

    points: an array (n, 3) for one line, a list of such arrays, or an object that has lines, see Mesh. radius: one number, an array for all
    points of all lines in turn, or the name of an array of points; by default 1/200 of the diagonal of their bounds. ends: flat, open or
    round. colors, values: per point of all lines in turn, or per line; or the name of an array of the object. transfer, look: see Mesh.
    """

    def __new__(
        cls, points: Any, *, radius: Any = None, ends: str = "flat", colors: Any = None, values: Any = None, transfer: Any = None, **look: Any
    ) -> "Tubes":
        data = _recognised("points", points) or _of_lines(points)
        if not data.lines:
            raise InvalidValue(f"{data.name} has no lines: its faces are drawn by Mesh, and its points by Spheres")
        radii, order = _radii(radius, data), np.concatenate(data.lines)
        if radii is not None and len(radii) > 1:
            radii = radii[order]
        made = Surface._tubes(data.points[order], [len(line) for line in data.lines], radii, ends)
        return _finished(cls, made, data, data.line_cells, colors, values, transfer, look, order)


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


def _finished(cls, made, data, cells, colors, values, transfer, look, points=None):
    """A surface with colours or values, and its look. cells, points: which entries of arrays are those of its cells and points."""
    if colors is not None and values is not None:
        raise InvalidValue("colors and values are both given: give either")
    if transfer is not None and values is None and data.values is None:
        raise InvalidValue("transfer colours values: give values, too")
    if colors is None and values is None and look.get("color") is None:
        colors, values = data.colors, data.values
    for name, given, convert in (("colors", colors, _rgba), ("values", values, _scalars)):
        if given is None:
            continue
        entries, of_cells = _attribute(name, given, data, cells is not None)
        entries = convert(name, entries)
        chosen = cells if of_cells else points
        entries = np.require(entries if chosen is None else entries[chosen], np.float32, "C")
        made = made._colored(entries, of_cells) if name == "colors" else made._valued(entries, of_cells, transfer)
    return Surface.__new__(cls, made.replaced(**look))


def _attribute(name, given, data, has_cells):
    """Entries per point or per cell, and whether they are those of cells."""
    if isinstance(given, str):
        for arrays, of_cells in ((data.point_arrays, False), (data.cell_arrays, True)):
            if given in arrays and (has_cells or not of_cells):
                return np.asarray(arrays[given]), of_cells
        known = list(data.point_arrays) + (list(data.cell_arrays) if has_cells else [])
        raise InvalidValue(f"{name} is {given!r}: {data.name} has " + (f"the arrays {', '.join(known)}" if known else "no arrays"))
    with accepting(name, given, "an array, or the name of an array"):
        entries = np.asarray(given)
    if entries.ndim > 0 and len(entries) == len(data.points):
        return entries, False
    if entries.ndim > 0 and has_cells and len(entries) == data.cells:
        return entries, True
    count = f"{len(entries)} entries" if entries.ndim else "one entry"
    cells = f", or {data.cells} cells" if has_cells else ""
    raise InvalidValue(f"{name} has {count} for {len(data.points)} points{cells}: give one each")


def _rgba(name, entries):
    """Colours (n, 4), 0 … 1."""
    if entries.ndim != 2 or entries.shape[1] not in (3, 4):
        raise InvalidValue(f"{name} has the shape {entries.shape}: give red, green, blue, and possibly alpha, of each")
    if entries.dtype.kind not in "uif" or entries.dtype.kind != "f" and entries.dtype != np.uint8:
        raise InvalidValue(f"{name} is of type {entries.dtype}: give uint8, or floats from 0 to 1")
    rgba = np.ones((len(entries), 4), np.float32)
    rgba[:, : entries.shape[1]] = entries / np.float32(255) if entries.dtype == np.uint8 else entries
    return rgba


def _scalars(name, entries):
    """A value each: the only component, or the magnitude of several."""
    with accepting(name, entries, "numbers"):
        entries = entries.astype(np.float32)
    if entries.ndim == 2:
        entries = entries[:, 0] if entries.shape[1] == 1 else np.linalg.norm(entries.astype(float), axis=1)
    if entries.ndim != 1:
        raise InvalidValue(f"{name} has the shape {entries.shape}: give a number, or a vector, of each")
    return entries


def _radii(radius, data):
    """An array of one radius, or of one per point; None for the default."""
    if radius is None:
        return None
    if isinstance(radius, str):
        radius = _attribute("radius", radius, data, False)[0]
    with accepting("radius", radius, "a number, an array, or the name of an array of points"):
        radii = np.require(np.atleast_1d(np.asarray(radius, dtype=float)), float, "C")
    if radii.shape not in ((1,), (len(data.points),)):
        raise InvalidValue(f"radius has the shape {radii.shape} for {len(data.points)} points: give one number, or one each")
    return radii


def _points(name, given):
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


def _polygons(name, faces):
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


def _of_lines(points):
    """Data of one line, or of a list of lines."""
    is_list = isinstance(points, (list, tuple)) or not hasattr(points, "dtype") and hasattr(points, "__len__")
    if not is_list or (len(points) and np.ndim(points[0]) == 1):
        points = [points]
    parts = [_points("points", line) for line in points]
    ends = np.cumsum([len(line) for line in parts], dtype=np.intp)
    data = Data("points", np.concatenate(parts) if parts else np.empty((0, 3)))
    return data.with_lines([np.arange(end - len(line), end) for line, end in zip(parts, ends)])


def _recognised(name, given) -> Optional[Data]:
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
        return Data(type(given).__name__, _points(name, given.vertices), colors=_nonempty(given.colors))
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
        _points("points", given.points),
        cells=len(_row("verts", np.asarray(given.verts))[0]),
        normals=arrays.get("Normals"),
        point_arrays=arrays,
        cell_arrays=dict(given.cell_data.items()),
    )
    data = data.with_lines([lines[start : start + count] for start, count in zip(*_row("lines", lines))])
    return data.with_polygons(_polygons("faces", given.faces))


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
    data = Data(name, _points("points", points), point_arrays=dict(given.point_data), cell_arrays=joined)
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
        _points("vertices", given.vertices),
        normals=np.asarray(given.vertex_normals),
        colors=None if colors is None else np.asarray(getattr(visual, colors)),
        point_arrays=dict(getattr(given, "vertex_attributes", {})),
        cell_arrays=dict(getattr(given, "face_attributes", {})),
    )
    return data.with_polygons(_polygons("faces", given.faces))


def _napari(vertices, faces, values=None):
    """The data of a surface layer of napari: vertices in the order of an array's axes, z, y, x."""
    data = Data("the tuple", _points("vertices", np.asarray(vertices, dtype=float)[:, ::-1]), values=values)
    return data.with_polygons(_polygons("faces", faces))


def color(given):
    """Red, green and blue, 0 … 1, and alpha or None."""
    with accepting("color", given, "#rrggbb or (red, green, blue), 0 to 1, possibly with alpha"):
        alpha = None if isinstance(given, str) or len(given) != 4 else float(given[3])
        found = _color(given)
    if not all(0 <= c <= 1 for c in (*found, 0.0 if alpha is None else alpha)):
        raise InvalidValue(f"color is {given}: expected #rrggbb or (red, green, blue), 0 to 1, possibly with alpha")
    return found, alpha


def matrix(given):
    """16 numbers, row by row."""
    with accepting("matrix", given, "an array of 4 x 4 numbers"):
        found = np.asarray(given, dtype=float)
    if found.shape not in ((4, 4), (3, 4)):
        raise InvalidValue(f"matrix has the shape {found.shape}: give 4 x 4 numbers")
    return np.vstack([found, [0.0, 0.0, 0.0, 1.0]])[:4].ravel().tolist()


def framed(framing: Framing, surfaces: Iterable[Surface]) -> Framing:
    """A framing with visible surfaces."""
    for surface in surfaces:
        own = surface.framing() if surface.visible else None
        framing = framing if own is None else framing.joined(own)
    return framing
