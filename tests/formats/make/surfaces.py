"""Surfaces, written with VTK, trimesh and plyfile, and by hand: a box of six quadrilaterals, two lines, and points (tests/formats/surfaces.rs)."""
import nibabel
import numpy as np
import plyfile
import trimesh
import vtk
from vtk.util.numpy_support import numpy_to_vtk
from common import folder

LOWEST, SIZE = np.array([1.0, -2.0, 3.0]), np.array([1.5, 2.0, 4.0])
CORNERS = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)])
POINTS = LOWEST + CORNERS * SIZE
# Their fronts are outside.
SIDES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
# Another triangulation of the sides: a strip around x, and two at the ends.
STRIPS = [[0, 1, 4, 5, 6, 7, 2, 3, 0, 1], [0, 4, 2, 6], [1, 3, 5, 7]]
COLORS = (CORNERS * 255).astype("uint8")
VALUES = POINTS @ [1, 10, 100]
LINES = [[0, 1, 3, 2, 6], [4, 5]]


def named(data, name):
    values = numpy_to_vtk(np.ascontiguousarray(data), deep=True)
    values.SetName(name)
    return values


def cells(lists):
    found = vtk.vtkCellArray()
    for points in lists:
        found.InsertNextCell(len(points), points)
    return found


def polydata(points="float64", sides=True, strips=False, lines=False, vertices=False):
    data = vtk.vtkPolyData()
    data.SetPoints(vtk.vtkPoints())
    data.GetPoints().SetData(numpy_to_vtk(POINTS.astype(points), deep=True))
    count = 0
    for wanted, put, lists in [(vertices, data.SetVerts, [[7], [3, 5]]), (lines, data.SetLines, LINES), (sides, data.SetPolys, SIDES),
                               (strips, data.SetStrips, STRIPS)]:
        if wanted:
            put(cells(lists))
            count += len(lists)
    data.GetPointData().AddArray(named(VALUES.astype("float32"), "values"))
    data.GetPointData().AddArray(named(POINTS - LOWEST, "from the corner"))
    data.GetCellData().AddArray(named(np.arange(count, dtype="int32"), "cell"))
    return data


def legacy(at, name, data, binary, version, header=None):
    writer = vtk.vtkPolyDataWriter()
    writer.SetFileName(str(at / name))
    writer.SetInputData(data)
    writer.SetFileType(vtk.VTK_BINARY if binary else vtk.VTK_ASCII)
    writer.SetFileVersion(version)
    if header:
        writer.SetHeader(header)
    writer.Write()


def xml(at, name, data, mode="Appended", packer=None, encode=False, wide=False, pieces=1):
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(str(at / name))
    writer.SetInputData(data)
    getattr(writer, f"SetDataModeTo{mode}")()
    writer.SetCompressor(packer)
    writer.SetEncodeAppendedData(encode)
    if wide:
        writer.SetHeaderTypeToUInt64()
    writer.SetNumberOfPieces(pieces)
    writer.Write()


def strings(data, name, text):
    values = vtk.vtkStringArray()
    values.SetName(name)
    values.InsertNextValue(text)
    data.GetFieldData().AddArray(values)
    return data


def surfaces():
    at = folder("surfaces")
    box = polydata()
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputData(box)
    triangles.Update()
    for name, kind in [("text.stl", vtk.VTK_ASCII), ("binary.stl", vtk.VTK_BINARY)]:
        writer = vtk.vtkSTLWriter()
        writer.SetFileName(str(at / name))
        writer.SetInputData(triangles.GetOutput())
        writer.SetFileType(kind)
        writer.SetHeader("solid box SPACE=LPS" if kind == vtk.VTK_BINARY else "box")
        writer.Write()
    fan = [[side[0], side[i], side[i + 1]] for side in SIDES for i in (1, 2)]
    (at / "trimesh.stl").write_bytes(trimesh.exchange.stl.export_stl(trimesh.Trimesh(POINTS, fan, process=False)))

    colored = polydata("float32")
    colored.GetPointData().SetScalars(named(COLORS, "paint"))
    normals = named((CORNERS * 2.0 - 1).astype("float32"), "outward")
    colored.GetPointData().SetNormals(normals)
    for name, kind, order in [("text.ply", vtk.VTK_ASCII, "LittleEndian"), ("little.ply", vtk.VTK_BINARY, "LittleEndian"),
                              ("big.ply", vtk.VTK_BINARY, "BigEndian")]:
        writer = vtk.vtkPLYWriter()
        writer.SetFileName(str(at / name))
        writer.SetInputData(colored)
        writer.SetFileType(kind)
        getattr(writer, f"SetDataByteOrderTo{order}")()
        writer.SetArrayName("paint")
        writer.AddComment("SPACE=RAS")
        writer.Write()
    vertex = np.zeros(8, dtype=[("x", "f8"), ("y", "f8"), ("z", "f8"), ("values", "f4")])
    for axis, name in enumerate("xyz"):
        vertex[name] = POINTS[:, axis]
    vertex["values"] = VALUES
    face = np.zeros(6, dtype=[("vertex_index", "O"), ("cell", "u1"), ("red", "u1"), ("green", "u1"), ("blue", "u1"), ("alpha", "u1")])
    for n, side in enumerate(SIDES):
        face[n] = (np.array(side, "u4"), n, 255, 0, 51 * n, 102)
    strip = np.zeros(1, dtype=[("vertex_indices", "O")])
    strip[0] = (np.array(sum(([*points, -1] for points in STRIPS), [])[:-1], "i4"),)
    element = plyfile.PlyElement.describe
    for name, text, order in [("faces_text.ply", True, "="), ("faces_big.ply", False, ">"), ("faces_little.ply", False, "<")]:
        plyfile.PlyData([element(vertex, "vertex"), element(face, "face")], text=text, byte_order=order).write(str(at / name))
    plyfile.PlyData([element(vertex, "vertex"), element(strip, "tristrips")], byte_order="<").write(str(at / "strips.ply"))
    plyfile.PlyData([element(vertex, "vertex")], text=True).write(str(at / "points.ply"))

    colored = polydata("float32")
    colored.GetPointData().SetScalars(named(COLORS, "paint"))
    colored.GetPointData().SetNormals(normals)
    for version in (42, 51):
        for kind in ("text", "binary"):
            legacy(at, f"{kind}_{version}.vtk", box, kind == "binary", version)
            legacy(at, f"colors_{kind}_{version}.vtk", colored, kind == "binary", version, "3D Slicer output. SPACE=RAS")
            legacy(at, f"strips_{kind}_{version}.vtk", polydata(sides=False, strips=True), kind == "binary", version)
            legacy(at, f"all_{kind}_{version}.vtk", polydata(lines=True, vertices=True), kind == "binary", version)
    legacy(at, "points.vtk", polydata(sides=False), True, 51)
    legacy(at, "space.vtk", strings(polydata(), "SPACE", "LPS"), True, 51)
    zlib, lz4 = vtk.vtkZLibDataCompressor(), vtk.vtkLZ4DataCompressor()
    xml(at, "text.vtp", box, "Ascii")
    xml(at, "inline.vtp", box, "Binary")
    xml(at, "inline_zlib.vtp", box, "Binary", zlib)
    xml(at, "appended.vtp", box, wide=True)
    xml(at, "appended_lz4.vtp", box, packer=lz4)
    xml(at, "appended_zlib.vtp", strings(polydata(), "SPACE", "LPS"), packer=zlib, encode=True)
    xml(at, "text_space.vtp", strings(polydata(), "SPACE", "RAS"), "Ascii")
    xml(at, "colors.vtp", colored)
    xml(at, "strips.vtp", polydata(sides=False, strips=True), "Ascii")
    xml(at, "all.vtp", polydata(lines=True, vertices=True), packer=zlib)
    xml(at, "pieces.vtp", polydata(lines=True), pieces=3)
    xml(at, "points.vtp", polydata(sides=False), "Ascii")
    others(at, fan)


def gifti(points, triangles, encoding, matrix=np.eye(4), metadata={}, spaces=("NIFTI_XFORM_UNKNOWN", "NIFTI_XFORM_SCANNER_ANAT"), more=()):
    from nibabel import gifti

    system = gifti.GiftiCoordSystem(*(nibabel.nifti1.xform_codes.code[space] for space in spaces), matrix)
    array = gifti.GiftiDataArray
    pointset = array(points.astype("float32"), "NIFTI_INTENT_POINTSET", coordsys=system, encoding=encoding, meta=metadata)
    faces = array(np.array(triangles, "int32"), "NIFTI_INTENT_TRIANGLE", encoding=encoding)
    return gifti.GiftiImage(darrays=[pointset, faces, *more])


def others(at, fan):
    """OBJ, GIFTI and FreeSurfer, and files of values and labels of the points of GIFTI and FreeSurfer."""
    from nibabel import freesurfer, gifti as g

    trimesh.Trimesh(POINTS, fan, process=False, vertex_normals=CORNERS * 2.0 - 1).export(at / "trimesh.obj")
    array = g.GiftiDataArray
    values = array(VALUES.astype("float32"), "NIFTI_INTENT_SHAPE", encoding="GIFTI_ENCODING_ASCII", meta={"Name": "values"})
    centre = np.array([5.0, -6.5, 20.0])
    placed, stated = np.eye(4), {f"VolGeomC_{axis}": str(c) for axis, c in zip("RAS", centre)}
    placed[:3, 3] = centre
    scanner = ("NIFTI_XFORM_SCANNER_ANAT",) * 2
    for name, image in [
        ("text.surf.gii", gifti(POINTS, fan, "GIFTI_ENCODING_ASCII", more=[values])),
        ("base64.surf.gii", gifti(POINTS, fan, "GIFTI_ENCODING_B64BIN")),
        ("gzip.surf.gii", gifti(POINTS, fan, "GIFTI_ENCODING_B64GZ", metadata=stated, spaces=scanner)),
        ("matrix.surf.gii", gifti(POINTS - centre, fan, "GIFTI_ENCODING_B64GZ", placed, stated)),
        ("centre.surf.gii", gifti(POINTS - centre, fan, "GIFTI_ENCODING_B64GZ", metadata=stated)),
    ]:
        nibabel.save(image, at / name)
    # Along the axes of a volume of sagittal slices, and of one that is turned by 90° about x.
    for name, axes in [("lh.box", [[-1, 0, 0], [0, 0, -1], [0, 1, 0]]), ("lh.turned", [[-1, 0, 0], [0, 1, 0], [0, 0, 1]])]:
        turn = np.array(axes).T @ np.array([[-1, 0, 0], [0, 0, -1], [0, 1, 0]])
        info = {"head": np.array([2, 0, 20]), "valid": "1  # volume info valid", "filename": "a.mgz", "volume": np.array([256, 256, 256]),
                "voxelsize": np.ones(3), **{f"{axis}ras": np.array(v, float) for axis, v in zip("xyz", axes)}, "cras": centre}
        freesurfer.write_geometry(at / name, (POINTS - centre) @ turn, np.array(fan), volume_info=info)
    freesurfer.write_geometry(at / "lh.plain", POINTS, np.array(fan))

    data = folder("surface_data")
    shape = array(VALUES.astype("float32"), "NIFTI_INTENT_SHAPE", encoding="GIFTI_ENCODING_B64GZ")
    column = array((POINTS - LOWEST).astype("float32"), "NIFTI_INTENT_VECTOR", encoding="GIFTI_ENCODING_B64BIN", ordering="F")
    column.ind_ord = 2
    nibabel.save(g.GiftiImage(darrays=[shape, column]), data / "box.func.gii")
    table = g.GiftiLabelTable()
    for key, name, color in [(1, "low", (1, 0, 0, 1)), (2, "high", (0, 0, 1, 0.5))]:
        label = g.GiftiLabel(key, *color)
        label.label = name
        table.labels.append(label)
    labels = array((CORNERS[:, 2] + 1).astype("int32"), "NIFTI_INTENT_LABEL", encoding="GIFTI_ENCODING_B64GZ")
    nibabel.save(g.GiftiImage(darrays=[labels], labeltable=table), data / "box.label.gii")
    freesurfer.write_morph_data(data / "lh.thickness", VALUES.astype("float32"))
    colors = np.array([[255, 0, 0, 0], [0, 0, 255, 0]])
    freesurfer.write_annot(data / "lh.parts.annot", CORNERS[:, 2], colors, ["low", "high"], fill_ctab=True)
    # Sides in the colours of materials.
    lines = ["# SPACE=RAS", "mtllib sides.mtl"] + ["v %g %g %g" % tuple(p) for p in POINTS]
    for n, side in enumerate(SIDES):
        lines += [f"usemtl side {n % 2}", "f " + " \\\n ".join(str(point - 8) for point in side)]
    (data / "materials.obj").write_text("\n".join(lines) + "\n")
    (data / "sides.mtl").write_text("newmtl side 0\nKd 1 0 0\nd 0.5\n\nnewmtl side 1\nKa 1 1 1\nKd 0 0.2 1\nTr 0.5\n")
