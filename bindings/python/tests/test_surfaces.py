"""Surfaces in and around volumes, from arrays and from objects with the attributes of pyvista, trimesh and meshio."""

from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

import layersplat
from layersplat import Mesh, Renderer, Spheres, Surface, Tubes

SIZE = (48, 40)
CORNERS = np.array([[4, 4, 4], [22, 5, 6], [20, 18, 8], [5, 17, 16]], float)
FACES = np.array([[0, 1, 2], [0, 2, 3]])


class Fields(dict):
    """Arrays by name, as pyvista has them."""


def polydata(**parts):
    empty = np.empty(0, int)
    given = {"points": CORNERS, "faces": empty, "lines": empty, "verts": empty, "point_data": Fields(), "cell_data": Fields()}
    return SimpleNamespace(**{**given, **parts})


def padded(cells):
    return np.concatenate([[len(cell), *cell] for cell in cells])


@pytest.fixture(scope="module")
def drawn(array, transfer):
    """Draws surfaces in the volume, as floats."""
    renderer = Renderer(array, transfer)
    camera = renderer.camera(SIZE, azimuth=30, elevation=20)

    def draw(*surfaces):
        renderer.set_surfaces(list(surfaces))
        return renderer.render_float(camera, SIZE)

    return draw


def test_the_commands_picture(array, command, tmp_path):
    file, ply = tmp_path / "volume_28x24x20_uint8.raw", tmp_path / "mesh.ply"
    array.tofile(file)
    header = ["ply", "format ascii 1.0", "element vertex 4", *(f"property float {axis}" for axis in "xyz")]
    rows = [" ".join(map(str, row)) for row in CORNERS] + [" ".join(map(str, [3, *face])) for face in FACES]
    ply.write_text("\n".join([*header, "element face 2", "property list uchar int vertex_indices", "end_header", *rows, ""]))
    common = ["--size", "48x40", "--up", "y", "--azimuth", "30", "--elevation", "20", "--transfer", "fire", "--transfer-range", "0,255"]
    look = "color=#3060c0,opacity=0.5,shading=flat,clip=off"
    command("render", file, "--surface", f"{ply},{look}", *common, "-o", tmp_path / "picture.png")
    expected = np.asarray(Image.open(tmp_path / "picture.png").convert("RGBA"))
    keywords = {"color": "#3060c0", "opacity": 0.5, "shading": "flat", "clip": False}
    (opened,) = Surface.open(ply)
    assert isinstance(opened, Mesh) and opened.name == "mesh.ply"
    for mesh in (Mesh(CORNERS, FACES, **keywords), opened.replaced(**keywords)):
        found = layersplat.render(array, clim=(0, 255), cmap="fire", size=SIZE, surfaces=[mesh])
        assert np.array_equal(found, expected)


def test_objects_are_their_arrays(drawn):
    alone = drawn()
    expected = drawn(Mesh(CORNERS, FACES))
    assert np.abs(expected - alone).max() > 0.1, "the mesh is seen"
    polygon = padded([[0, 1, 2, 3]])
    meshio = SimpleNamespace(points=CORNERS, cells_dict={"quad": np.array([[0, 1, 2, 3]])}, point_data={}, cell_data_dict={})
    zyx = CORNERS[:, ::-1]
    for mesh in [
        Mesh(polydata(faces=padded(FACES))),
        Mesh(polydata(faces=polygon)),
        Mesh(CORNERS, polygon),
        Mesh(CORNERS, [[0, 1, 2, 3]]),
        Mesh(meshio),
        Mesh((zyx, FACES)),
        Mesh(CORNERS - 1, FACES, matrix=[[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]]),
    ]:
        assert np.array_equal(drawn(mesh), expected), mesh
    # The order of axes matters.
    assert not np.array_equal(drawn(Mesh((CORNERS, FACES))), expected)
    normals = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, 0]], float)
    smooth = drawn(Mesh(CORNERS, FACES, normals=normals))
    assert not np.array_equal(smooth, expected)
    trimesh = SimpleNamespace(vertices=CORNERS, faces=FACES, vertex_normals=normals)
    assert np.array_equal(drawn(Mesh(trimesh)), smooth)
    assert np.array_equal(drawn(Mesh(polydata(faces=padded(FACES), point_data=Fields(Normals=normals)))), smooth)


def test_lines_and_points_of_objects(drawn):
    expected = drawn(Tubes([CORNERS[:3], CORNERS[2:]], radius=1.5, ends="round"))
    assert not np.array_equal(expected, drawn(Tubes([CORNERS[:3], CORNERS[2:]], radius=1.5)))
    pieces = {"line": np.array([[0, 1], [1, 2], [2, 3]])}
    lines = polydata(lines=padded([[0, 1, 2], [2, 3]]))
    assert np.array_equal(drawn(Tubes(lines, radius=1.5, ends="round")), expected)
    meshio = SimpleNamespace(points=CORNERS, cells_dict=pieces, point_data={}, cell_data_dict={})
    joined = Tubes(meshio, radius=1.5)
    assert joined.cells == 1 and np.array_equal(drawn(joined), drawn(Tubes(CORNERS, radius=1.5)))
    radii = np.array([1.0, 2.0, 3.0, 0.5])
    spheres = Spheres(CORNERS, radii)
    assert np.array_equal(drawn(Spheres(polydata(point_data=Fields(r=radii)), "r")), drawn(spheres))
    turned = polydata(lines=padded([[2, 1, 0]]), point_data=Fields(r=radii))
    order = [2, 1, 0]
    assert np.array_equal(drawn(Tubes(turned, radius="r")), drawn(Tubes(CORNERS[order], radius=radii[order])))
    lowest, highest = spheres.bounds
    assert np.allclose(lowest, (CORNERS - radii[:, None]).min(0)) and np.allclose(highest, (CORNERS + radii[:, None]).max(0))
    # 1/200 of the diagonal.
    (lowest, highest), diagonal = Spheres(CORNERS).bounds, np.linalg.norm(np.ptp(CORNERS, axis=0))
    assert np.allclose(np.subtract(highest, lowest) - np.ptp(CORNERS, axis=0), diagonal / 100)


def test_colours_and_values_are_those_of_their_points_and_cells(drawn):
    red, blue = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    flat = {"shading": "off"}
    expected = drawn(Mesh(CORNERS, FACES, colors=[red, blue], **flat))
    parts = [Mesh(CORNERS, FACES[:1], color=red, **flat), Mesh(CORNERS, FACES[1:], color=blue, **flat)]
    assert np.array_equal(drawn(*parts), expected)
    assert np.array_equal(drawn(Mesh(CORNERS, FACES, colors=np.array([[255, 0, 0], [0, 0, 255]], np.uint8), **flat)), expected)
    blue_to_red = layersplat.TransferFunction([(0, blue), (1, red)], [(0, 0), (1, 0)])
    assert np.array_equal(drawn(Mesh(CORNERS, FACES, values=[1, 0], transfer=blue_to_red, **flat)), expected)
    # Arrays of cells begin with those of single points and lines; polygons have one entry each.
    cells = Fields(c=np.array([0.5, 0.5, 1.0, 0.0]))
    data = polydata(verts=padded([[0]]), lines=padded([[0, 1]]), faces=padded(FACES), cell_data=cells)
    assert np.array_equal(drawn(Mesh(data, values="c", transfer=blue_to_red, **flat)), expected)
    mixed = polydata(faces=padded([[0, 1, 2, 3], [0, 1, 2]]), cell_data=Fields(c=np.array([0.0, 1.0])))
    quad, triangle = Mesh(CORNERS, [[0, 1, 2, 3]], color=blue, **flat), Mesh(CORNERS, FACES[:1], color=red, **flat)
    assert np.array_equal(drawn(Mesh(mixed, values="c", transfer=blue_to_red, **flat)), drawn(quad, triangle))
    kinds = {"line": np.array([[0, 1]]), "triangle": FACES}
    by_kind = {"c": {"line": np.array([0.5]), "triangle": np.array([1.0, 0.0])}}
    meshio = SimpleNamespace(points=CORNERS, cells_dict=kinds, point_data={}, cell_data_dict=by_kind)
    assert np.array_equal(drawn(Mesh(meshio, values="c", transfer=blue_to_red, **flat)), expected)
    visual = SimpleNamespace(kind="face", face_colors=np.array([[255, 0, 0, 255], [0, 0, 255, 255]], np.uint8))
    trimesh = SimpleNamespace(vertices=CORNERS, faces=FACES, vertex_normals=np.ones((4, 3)), visual=visual)
    assert np.array_equal(drawn(Mesh(trimesh, **flat)), expected)
    assert np.array_equal(drawn(Mesh(trimesh, color=red, **flat)), drawn(Mesh(CORNERS, FACES, color=red, **flat))), "another colour"
    # A vector has its length, per point; viridis by default.
    vectors = polydata(faces=padded(FACES), point_data=Fields(v=3 * np.eye(4, 3)))
    plain = Mesh(CORNERS, FACES, values=[3, 3, 3, 0], transfer="viridis", **flat)
    assert np.array_equal(drawn(Mesh(vectors, values="v", **flat)), drawn(plain))
    assert np.array_equal(drawn(Mesh((CORNERS[:, ::-1], FACES, [3, 3, 3, 0]), **flat)), drawn(plain))
    two = [CORNERS[:2], CORNERS[2:]]
    lines = [Tubes(line, radius=1, color=color, **flat) for line, color in zip(two, (red, blue))]
    assert np.array_equal(drawn(Tubes(two, radius=1, colors=[red, blue], **flat)), drawn(*lines))


def test_surfaces_are_replaced(drawn):
    alone = drawn()
    mesh = Mesh(CORNERS, FACES, color=(1, 0, 0, 0.25), name="m")
    assert mesh.opacity == 0.25 and mesh.replaced(opacity=0.5).opacity == 0.5 and mesh.opacity == 0.25
    hidden = mesh.replaced(visible=False)
    assert type(hidden) is Mesh and np.array_equal(drawn(hidden), alone) and repr(hidden) == "<layersplat.Mesh m of 4 points and 2 cells, hidden>"
    assert not np.array_equal(drawn(hidden.replaced(visible=True)), alone)
    assert np.array_equal(drawn(), alone)


def test_views_are_fitted_to_surfaces(array):
    far = Mesh(CORNERS + [60, 0, 0], FACES, color=(1, 1, 1), shading="off")
    look = {"size": SIZE, "azimuth": 0, "elevation": 0, "quality": "draft"}
    for data in (array, [array, array]):
        found = layersplat.render(data, surfaces=[far], **look)
        assert (found[..., :3].min(-1) == 255).any(), "the mesh is in the picture"
        assert np.array_equal(layersplat.render(data, surfaces=[far.replaced(visible=False)], **look), layersplat.render(data, **look))


def test_surfaces_alone_fill_the_picture():
    ball = Spheres([[100, 20, -7]], 5, color=(1, 0.5, 0), shading="off")
    picture = layersplat.render(None, surfaces=[ball, ball.replaced(visible=False)], size=64, background="transparent")
    assert (picture[32, 32] == (255, 128, 0, 255)).all() and (picture[0, 0] == 0).all()
    # A disc that nearly fills it.
    assert 0.3 < (picture[..., 3] == 255).mean() < 0.8
    flat = Mesh([[0, 0, 0], [8, 0, 0], [8, 8, 0], [0, 8, 0]], FACES, shading="off")
    assert (layersplat.render(None, surfaces=[flat], size=64, background="transparent")[..., 3] > 0).mean() > 0.3, "it is not seen from its edge"


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: Mesh(CORNERS), "faces is missing"),
        (lambda: Mesh(CORNERS[:, :2], FACES), r"vertices has the shape \(4, 2\)"),
        (lambda: Mesh(CORNERS, FACES + 2), "faces has the index 5, and there are 4 vertices"),
        (lambda: Mesh(CORNERS, FACES - 1), "faces has the index -1"),
        (lambda: Mesh(CORNERS, FACES * 1.0), "faces is of type float64"),
        (lambda: Mesh(CORNERS, [3, 0, 1]), "faces ends within a cell of 3 points"),
        (lambda: Mesh(CORNERS * np.nan, FACES), r"point 0 is \[NaN, NaN, NaN\]"),
        (lambda: Mesh(CORNERS, FACES, normals=CORNERS[:3]), "normals has 3 entries for 4 vertices"),
        (lambda: Mesh(CORNERS, FACES, colors=np.ones((3, 3))), "colors has 3 entries for 4 points, or 2 cells"),
        (lambda: Mesh(CORNERS, FACES, colors=np.ones((4, 2))), r"colors has the shape \(4, 2\)"),
        (lambda: Mesh(CORNERS, FACES, colors=np.ones((4, 3), int)), "colors is of type int64: give uint8"),
        (lambda: Mesh(CORNERS, FACES, colors=2 * np.ones((4, 3))), "a colour is"),
        (lambda: Mesh(CORNERS, FACES, transfer="fire"), "give values, too"),
        (lambda: Mesh(CORNERS, FACES, values=[1, 2], transfer="no"), "unknown transfer function 'no'"),
        (lambda: Mesh(CORNERS, FACES, color="red"), "'red' is not a colour"),
        (lambda: Mesh(CORNERS, FACES, opacity=2), "opacity is 2"),
        (lambda: Mesh(CORNERS, FACES, shading="phong"), "unknown shading 'phong': use smooth, flat or off"),
        (lambda: Mesh(CORNERS, FACES, matrix=np.eye(3)), r"matrix has the shape \(3, 3\)"),
        (lambda: Mesh(CORNERS, FACES, matrix=np.zeros((4, 4))), "its matrix is not affine, or has no inverse"),
        (lambda: Mesh(polydata(), FACES), "faces: leave it out"),
        (lambda: Mesh(polydata()), "has no faces: its points are drawn by Spheres"),
        (lambda: Mesh(polydata(faces=padded(FACES), point_data=Fields(p=[1])), values="q"), "values is 'q': SimpleNamespace has the arrays p"),
        (lambda: Mesh(SimpleNamespace(extract_surface=None)), "give its surface, vertices.extract_surface()"),
        (lambda: Spheres(CORNERS, [1, 2]), r"radius has the shape \(2,\) for 4 points"),
        (lambda: Spheres(CORNERS, -1), "radius 0 is -1: a radius is 0 or positive"),
        (lambda: Spheres(CORNERS, matrix=np.diag([1, 2, 3, 1])), "scale alike along all axes"),
        (lambda: Tubes(polydata()), "has no lines"),
        (lambda: Tubes(CORNERS, ends="square"), "unknown ends 'square'"),
        (lambda: Surface.open("missing.stl"), "cannot read missing.stl"),
        (lambda: Renderer(np.zeros((4, 4, 4))).set_surfaces([CORNERS]), "expected a list of layersplat.Mesh, Spheres and Tubes"),
        (lambda: layersplat.volshow(np.zeros((4, 4, 4)), surfaces=[]), "live views draw none"),
        (lambda: layersplat.render(None), "data is None: give a volume, or surfaces"),
        (lambda: layersplat.render(None, cmap="fire", surfaces=[Mesh(CORNERS, FACES)]), "cmap: leave it out, there is no volume"),
    ],
)
def test_what_is_wrong_is_named(make, words):
    with pytest.raises(layersplat.Error, match=words):
        make()
