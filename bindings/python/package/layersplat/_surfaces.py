"""Surfaces: meshes, spheres and tubes, and how they look."""

import functools
from typing import Any, Iterable, Optional

import numpy as np

from ._checks import accepting
from ._errors import InvalidValue
from ._layersplat import Framing, Surface
from ._surface_data import Data, of_lines, points_of, polygons_of, recognised
from ._transfer import _color


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
        data = recognised("vertices", vertices)
        if data is None:
            data = Data("faces", points_of("vertices", vertices))
            if faces is None:
                raise InvalidValue("faces is missing: give an array (m, 3) of indices, or an object that has vertices and faces")
            data = data.with_polygons(polygons_of("faces", faces))
        elif faces is not None:
            raise InvalidValue(f"faces: leave it out, vertices is a {type(vertices).__name__}, which has its own")
        if not len(data.triangles):
            raise InvalidValue(f"{data.name} has no faces: its points are drawn by Spheres, and its lines by Tubes")
        normals = data.normals if normals is None else points_of("normals", normals)
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
        data = recognised("centres", centres) or Data("centres", points_of("centres", centres))
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
        data = recognised("points", points) or of_lines(points)
        if not data.lines:
            raise InvalidValue(f"{data.name} has no lines: its faces are drawn by Mesh, and its points by Spheres")
        radii, order = _radii(radius, data), np.concatenate(data.lines)
        if radii is not None and len(radii) > 1:
            radii = radii[order]
        made = Surface._tubes(data.points[order], [len(line) for line in data.lines], radii, ends)
        return _finished(cls, made, data, data.line_cells, colors, values, transfer, look, order)


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


def framing_of(surfaces: Iterable[Surface]) -> Optional[Framing]:
    """The framing of visible surfaces, if they have any points."""
    framings = [framing for surface in surfaces if surface.visible and (framing := surface.framing()) is not None]
    return functools.reduce(Framing.joined, framings) if framings else None


def framed(framing: Framing, surfaces: Iterable[Surface]) -> Framing:
    """A framing with visible surfaces."""
    own = framing_of(surfaces)
    return framing if own is None else framing.joined(own)
