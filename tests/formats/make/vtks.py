"""VTK image data, written with VTK."""
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk
from common import affine, array, folder, holds, turned


def vtk_image(data, spacing=(1, 1, 1), origin=(0, 0, 0), name="values", first=(0, 0, 0), components=1):
    image = vtk.vtkImageData()
    z, y, x = data.shape[:3]
    image.SetExtent(first[0], first[0] + x - 1, first[1], first[1] + y - 1, first[2], first[2] + z - 1)
    image.SetSpacing(spacing)
    image.SetOrigin(origin)
    values = numpy_to_vtk(data.reshape(-1, components) if components > 1 else data.ravel(), deep=True)
    values.SetName(name)
    image.GetPointData().SetScalars(values)
    return image


def cut_in_pieces(path, data, extents):
    """Written by hand: int16 point data, and cell data that count up."""
    cells = np.arange(4 * 3 * 2).reshape(2, 3, 4)
    text = ['<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
            '<ImageData WholeExtent="0 4 0 3 0 2" Origin="1 -2 3" Spacing="0.5 1.5 2">']
    appended = b""
    for x, x2, y, y2, z, z2 in extents:
        text += [f'<Piece Extent="{x} {x2} {y} {y2} {z} {z2}"><PointData Scalars="values">']
        numbers = np.ascontiguousarray(data[z:z2 + 1, y:y2 + 1, x:x2 + 1]).tobytes()
        text += [f'<DataArray type="Int16" Name="values" format="appended" offset="{len(appended)}"/></PointData><CellData>']
        appended += len(numbers).to_bytes(8, "little") + numbers
        numbers = " ".join(str(n) for n in cells[z:z2, y:y2, x:x2].ravel())
        text += [f'<DataArray type="Int32" Name="pressure" format="ascii">{numbers}</DataArray></CellData></Piece>']
    text += ['</ImageData><AppendedData encoding="raw">_']
    path.write_bytes("\n".join(text).encode() + appended + b"</AppendedData></VTKFile>\n")


def vtks():
    at = folder("vtk")
    spacing, origin = (0.5, 1.5, 2), (1, -2, 3)
    place = affine(spacing, origin)

    def put(name, image, mode="Appended", packer=None, change=lambda writer: None):
        writer = vtk.vtkXMLImageDataWriter()
        writer.SetFileName(str(at / name))
        writer.SetInputData(image)
        getattr(writer, f"SetDataModeTo{mode}")()
        writer.SetCompressor(packer)
        writer.SetEncodeAppendedData(False)
        change(writer)
        writer.Write()

    plain = vtk_image(array("int16", 100, -3000), spacing, origin)
    encoded = lambda w: w.SetEncodeAppendedData(True)
    for mode, coded in [("Ascii", None), ("Binary", None), ("Appended", None), ("Appended", encoded)]:
        for packed, packer in [("plain", None), ("zlib", vtk.vtkZLibDataCompressor()), ("lz4", vtk.vtkLZ4DataCompressor())]:
            if mode == "Ascii" and packer:
                continue
            name = f"{mode.lower()}{'_coded' if coded else ''}_{packed}.vti"
            put(name, plain, mode, packer, coded or (lambda w: None))
            holds(f"vtk/{name}", 100, -3000, place)

    def narrow(writer):
        writer.SetHeaderTypeToUInt32()
        writer.SetByteOrderToBigEndian()
        writer.SetBlockSize(64)

    def wide(writer):
        writer.SetHeaderTypeToUInt64()
        writer.SetBlockSize(64)

    for mode, packer in [("Appended", None), ("Binary", None), ("Binary", vtk.vtkZLibDataCompressor())]:
        name = f"wide_{mode.lower()}_{'packed' if packer else 'plain'}.vti"
        put(name, plain, mode, packer, wide)
        holds(f"vtk/{name}", 100, -3000, place)
    for mode, packer in [("Appended", None), ("Binary", vtk.vtkZLibDataCompressor()), ("Appended", vtk.vtkLZ4DataCompressor())]:
        name = f"big_{mode.lower()}_{'packed' if packer else 'plain'}.vti"
        put(name, plain, mode, packer, narrow)
        holds(f"vtk/{name}", 100, -3000, place)
    for dtype in "int8 uint8 uint16 int32 uint32 int64 uint64 float32 float64".split():
        low = -30 if dtype[0] in "if" else 1
        put(f"{dtype}.vti", vtk_image(array(dtype, 2, low), spacing, origin), packer=vtk.vtkZLibDataCompressor())
        holds(f"vtk/{dtype}.vti", 2, low, place)
    # Several pieces, each with the whole extent, as VTK writes them from a complete input.
    for name, mode, packer in [("whole_pieces", "Appended", None), ("whole_pieces_zlib", "Binary", vtk.vtkZLibDataCompressor())]:
        put(f"{name}.vti", plain, mode, packer, lambda writer: writer.SetNumberOfPieces(3))
        holds(f"vtk/{name}.vti", 100, -3000, place)
    # As simulations write them: pieces that share their boundary points.
    cut_in_pieces(at / "pieces.vti", array("int16", 100, -3000), [(0, 2, 0, 3, 0, 2), (2, 4, 0, 1, 0, 2), (2, 4, 1, 3, 0, 2)])
    holds("vtk/pieces.vti", 100, -3000, place)
    holds("vtk/pieces.vti", 1, 0, affine(spacing, np.add(origin, np.multiply(spacing, 0.5))), dims=(4, 3, 2), array="pressure")
    # A rotated grid whose extent does not start at 0.
    turn = turned(40)
    moved = vtk_image(array("float32", 0.5, -7), spacing, origin, first=(3, -2, 7))
    moved.SetDirectionMatrix(*turn.ravel())
    put("moved.vti", moved)
    point = [0.0] * 3
    moved.TransformIndexToPhysicalPoint(3, -2, 7, point)
    holds("vtk/moved.vti", 0.5, -7, affine(spacing, point, turn))
    # Several arrays, one with three components, one of cell data.
    several = vtk_image(np.stack([array("float32", 0.5, 10 * n) for n in range(3)], -1), spacing, origin, "flow", components=3)
    for data, name in [(array("uint8", 1, 0), "first"), (array("int16", 9, 1), "second")]:
        more = numpy_to_vtk(data.ravel(), deep=True)
        more.SetName(name)
        several.GetPointData().AddArray(more)
    cells = numpy_to_vtk(np.arange(4 * 3 * 2, dtype="float64"), deep=True)
    cells.SetName("pressure")
    several.GetCellData().AddArray(cells)
    several.GetPointData().SetActiveScalars("second")
    put("several.vti", several)
    holds("vtk/several.vti", 9, 1, place)
    holds("vtk/several.vti", 1, 0, place, array="first")
    holds("vtk/several.vti", 0.5, 20, place, array="flow", channel=2)
    cell_place = affine(spacing, np.add(origin, np.multiply(spacing, 0.5)))
    holds("vtk/several.vti", 1, 0, cell_place, dims=(4, 3, 2), array="pressure")

    for version in [42, 51]:
        for ascii_, mode in [(True, "ascii"), (False, "binary")]:
            for dtype in ["int16", "uint8", "float64"] + (["int64"] if not ascii_ else []):
                writer = vtk.vtkStructuredPointsWriter()
                points = vtk.vtkStructuredPoints()
                points.DeepCopy(vtk_image(array(dtype, 2, 1), spacing, origin))
                writer.SetInputData(points)
                writer.SetFileVersion(version)
                (writer.SetFileTypeToASCII if ascii_ else writer.SetFileTypeToBinary)()
                name = f"legacy_{version}_{mode}_{dtype}.vtk"
                writer.SetFileName(str(at / name))
                writer.Write()
                holds(f"vtk/{name}", 2, 1, place)
    points = vtk.vtkStructuredPoints()
    points.DeepCopy(several)
    for ascii_, mode in [(True, "ascii"), (False, "binary")]:
        writer = vtk.vtkStructuredPointsWriter()
        writer.SetInputData(points)
        (writer.SetFileTypeToASCII if ascii_ else writer.SetFileTypeToBinary)()
        name = f"legacy_several_{mode}.vtk"
        writer.SetFileName(str(at / name))
        writer.Write()
        holds(f"vtk/{name}", 9, 1, place)
        holds(f"vtk/{name}", 1, 0, place, array="first")
        holds(f"vtk/{name}", 0.5, 10, place, array="flow", channel=1)
        holds(f"vtk/{name}", 1, 0, cell_place, dims=(4, 3, 2), array="pressure")
    # As in files of 1998.
    (at / "legacy_30.vtk").write_text(
        "# vtk DataFile Version 3.0\nby hand\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\nASPECT_RATIO 0.5 1.5 2\n"
        "ORIGIN 1 -2 3\nPOINT_DATA 60\nSCALARS values unsigned_char\nLOOKUP_TABLE default\n"
        + " ".join(str(n) for n in range(60)) + "\n")
    holds("vtk/legacy_30.vtk", 1, 0, place)
