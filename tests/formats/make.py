#!/usr/bin/env python3
"""Writes the small files in files/, by writers that are not ours, and files/expected.json, which says what they hold.

    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install pynrrd nibabel SimpleITK vtk numpy tifffile pillow
    /tmp/venv/bin/python tests/formats/make.py

Voxel i (x fastest) of a volume of 5x4x3 holds slope * i + intercept. Places in the world are what the writers' own readers say,
with x to the right, y to the front and z up.
"""
import gzip, itertools, json, os, pathlib, shutil
import nibabel, nrrd, numpy as np, SimpleITK as sitk, tifffile, vtk
from PIL import Image
from vtk.util.numpy_support import numpy_to_vtk

HERE = pathlib.Path(__file__).parent / "files"
DIMS = (5, 4, 3)
LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
expected = []


def array(dtype, slope=1, intercept=0, more=()):
    """As (z, y, x), with `more` axes before."""
    count = int(np.prod(more + DIMS))
    return (np.arange(count) * slope + intercept).astype(dtype).reshape(more + DIMS[::-1])


def affine(spacing=(1, 1, 1), origin=(0, 0, 0), direction=np.eye(3)):
    m = np.eye(4)
    m[:3, :3] = np.asarray(direction, float) @ np.diag(spacing)
    m[:3, 3] = origin
    return m


def holds(name, slope=1, intercept=0, place=np.eye(4), dims=DIMS, strides=None, **options):
    """`strides`: how much i grows from voxel to voxel along x, y, z."""
    strides = strides or [1, dims[0], dims[0] * dims[1]]
    expected.append(dict(file=name, slope=float(slope), intercept=float(intercept), dims=list(dims), strides=list(strides),
                         affine=np.asarray(place, float)[:3].tolist(), **options))


def folder(name):
    path = HERE / name
    path.mkdir(parents=True)
    return path


def turned(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def nrrds():
    at = folder("nrrd")

    def put(name, data, options=None, **header):
        nrrd.write(str(at / name), data, header, index_order="C", **(options or {}))

    axes = dict(spacings=[0.5, 1.5, 2.0])
    spaced = affine((0.5, 1.5, 2.0))
    for dtype in "int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64".split():
        low = -30 if dtype[0] in "if" else 1
        put(f"{dtype}.nrrd", array(dtype, 2, low), encoding="gzip", **axes)
        holds(f"nrrd/{dtype}.nrrd", 2, low, spaced)
    for encoding in ["raw", "ascii"]:
        put(f"{encoding}.nrrd", array("int16", 100, -3000), encoding=encoding, **axes)
        holds(f"nrrd/{encoding}.nrrd", 100, -3000, spaced)
        put(f"detached_{encoding}.nhdr", array("int16", 100, -3000), encoding=encoding, **axes)
        holds(f"nrrd/detached_{encoding}.nhdr", 100, -3000, spaced)
    put("big.nrrd", array(">i2", 100, -3000), encoding="raw", endian="big", **axes)
    holds("nrrd/big.nrrd", 100, -3000, spaced)
    # ITK's writer: space left-posterior-superior, oblique, one axis backwards.
    image = sitk.GetImageFromArray(array("float32", 0.5, -7))
    direction = turned(30) @ np.diag([1, -1, 1.0])
    image.SetDirection(direction.ravel().tolist())
    image.SetSpacing((0.9, 1.1, 2.5))
    image.SetOrigin((10, -20, 30))
    sitk.WriteImage(image, str(at / "lps.nrrd"))
    holds("nrrd/lps.nrrd", 0.5, -7, LPS @ affine((0.9, 1.1, 2.5), (10, -20, 30), direction))
    sitk.WriteImage(image, str(at / "lps.nhdr"))
    holds("nrrd/lps.nhdr", 0.5, -7, LPS @ affine((0.9, 1.1, 2.5), (10, -20, 30), direction))
    # Axes in another order, one backwards.
    permuted = np.array([[0, 0, -3.0], [0.5, 0, 0], [0, 2.0, 0]])
    for space, change in [("right-anterior-superior", np.eye(4)), ("LPS", LPS), ("RAS", np.eye(4)),
                          ("left-anterior-superior", np.diag([-1.0, 1, 1, 1])), ("scanner-xyz", np.eye(4))]:
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = permuted, (1, 2, 3)
        header = {"space directions": permuted.T.tolist(), "space origin": [1, 2, 3], "space": space}
        put(f"permuted_{space}.nrrd", array("uint8", 4, 1), encoding="raw", **header)
        holds(f"nrrd/permuted_{space}.nrrd", 4, 1, change @ place)
    # Colours on the first axis.
    rgb = array("uint8", 1, 0, ()).repeat(3).reshape(3, 4, 5, 3) + np.arange(3, dtype="uint8") * 60
    put("rgb.nrrd", rgb, encoding="gzip", kinds=["RGB-color", "domain", "domain", "domain"],
        **{"space directions": [[np.nan] * 3, [1, 0, 0], [0, 1, 0], [0, 0, 2]], "space": "RAS", "space origin": [0, 0, 0]})
    for channel in [None, 0, 2]:
        holds("nrrd/rgb.nrrd", 1, 60 * (channel or 0), affine((1, 1, 2)), channel=channel)
    # Times on the last.
    put("times.nrrd", array("int16", 3, -5, (2,)), encoding="raw", kinds=["domain"] * 3 + ["time"],
        **{"space directions": [[1, 0, 0], [0, 1, 0], [0, 0, 2], [np.nan] * 3], "space": "RAS", "space origin": [0, 0, 0]})
    for frame in [None, 1]:
        holds("nrrd/times.nrrd", 3, -5 + 180 * (frame or 0), affine((1, 1, 2)), frame=frame)
    # What no writer at hand writes: numbered and listed files, hexadecimal digits, lines and bytes to skip.
    data = array("<u2", 7, 3)
    head = "NRRD0005\ntype: uint16\ndimension: 3\nsizes: 5 4 3\nendian: little\nspacings: 1 1 2\n"
    for z in range(3):
        (at / f"slice_{z + 8:02}.raw").write_bytes(data[z].tobytes())
    (at / "numbered.nhdr").write_text(head + "encoding: raw\ndata file: slice_%02d.raw 8 10 1\n")
    (at / "backwards.nhdr").write_text(head + "encoding: raw\ndata file: slice_%02d.raw 10 8 -1\n")
    (at / "listed.nhdr").write_text(head + "encoding: raw\ndata file: LIST\nslice_08.raw\nslice_09.raw\nslice_10.raw\n")
    (at / "planes.nhdr").write_text(head + "encoding: raw\ndata file: LIST 2\nslice_08.raw\nslice_09.raw\nslice_10.raw\n")
    for name in ["numbered", "listed", "planes"]:
        holds(f"nrrd/{name}.nhdr", 7, 3, affine((1, 1, 2)))
    holds("nrrd/backwards.nhdr", 7, 3 + 7 * 40, affine((1, 1, 2)), strides=[1, 5, -20])
    (at / "hex.nrrd").write_text(head + "encoding: hex\n\n" + data.tobytes().hex("\n", 20) + "\n")
    holds("nrrd/hex.nrrd", 7, 3, affine((1, 1, 2)))
    (at / "skipped.bin").write_bytes(b"two lines\nof something\nand" + data.tobytes())
    (at / "skipped.nhdr").write_text(head + "encoding: raw\nline skip: 2\nbyte skip: 3\ndata file: skipped.bin\n")
    (at / "at_the_end.nhdr").write_text(head + "encoding: raw\nbyte skip: -1\ndata file: skipped.bin\n")
    (at / "skipped.gz").write_bytes(gzip.compress(b"and" + data.tobytes(), mtime=0))
    (at / "packed.nhdr").write_text(head + "encoding: gzip\nbyte skip: 3\ndata file: skipped.gz\n")
    for name in ["skipped", "at_the_end", "packed"]:
        holds(f"nrrd/{name}.nhdr", 7, 3, affine((1, 1, 2)))


def niftis():
    at = folder("nifti")
    oblique = affine((0.9, 1.1, 2.5), (10, -20, 30), turned(25) @ np.diag([-1, 1, 1.0]))

    def put(name, data, kind=nibabel.Nifti1Image, place=oblique, slope=1, inter=0, change=lambda header: None, big=False, **options):
        image = kind(data.T, place, dtype=data.dtype)
        if big:
            image = kind(data.T, place, header=kind.header_class(endianness=">"), dtype=data.dtype)
        image.header.set_slope_inter(slope, inter)
        change(image.header)
        nibabel.save(image, str(at / name))
        return nibabel.load(str(at / name)).affine

    codes = "uint8 int8 int16 uint16 int32 uint32 int64 uint64 float32 float64".split()
    for dtype, (version, kind) in itertools.product(codes, [(1, nibabel.Nifti1Image), (2, nibabel.Nifti2Image)]):
        low = -30 if dtype[0] in "if" else 1
        if version == 2 and dtype not in ("int16", "float64"):
            continue
        name = f"{dtype}_{version}.nii.gz"
        holds(f"nifti/{name}", 2, low, put(name, array(dtype, 2, low), kind))
    for kind, version in [(nibabel.Nifti1Image, 1), (nibabel.Nifti2Image, 2)]:
        name = f"big_{version}.nii"
        holds(f"nifti/{name}", 100, -3000, put(name, array("int16", 100, -3000), kind, big=True))
        name = f"little_{version}.nii"
        holds(f"nifti/{name}", 100, -3000, put(name, array("int16", 100, -3000), kind))
    for kind, version in [(nibabel.Nifti1Pair, 1), (nibabel.Nifti2Pair, 2)]:
        for name in [f"pair_{version}.hdr", f"packed_pair_{version}.hdr.gz"]:
            place = put(name.replace(".hdr", ".img"), array("uint16", 9, 1), kind)
            holds(f"nifti/{name}", 9, 1, place)
            holds(f"nifti/{name}".replace(".hdr", ".img"), 9, 1, place)

    image = nibabel.Nifti1Image(array("int16").T, oblique)
    image.header.set_slope_inter(0.25, -12.5)
    nibabel.save(image, str(at / "scaled.nii"))
    assert (nibabel.load(str(at / "scaled.nii")).get_fdata().T == array("float64", 0.25, -12.5)).all()
    holds("nifti/scaled.nii", 0.25, -12.5, image.affine)
    # Slope 0: numbers are values.
    name = "no_slope.nii"
    place = put(name, array("int16", 100, -3000))
    raw = bytearray((at / name).read_bytes())
    raw[112:120] = np.array([0, 5], "<f4").tobytes()
    (at / name).write_bytes(raw)
    holds(f"nifti/{name}", 100, -3000, place)

    def only_q(header):
        header.set_qform(oblique, 1)
        header.set_sform(None, 0)

    name = "qform.nii"
    holds(f"nifti/{name}", 1, 0, put(name, array("uint8"), change=only_q))

    def both(header):
        header.set_qform(affine((1, 2, 3)), 1)
        header.set_sform(oblique, 2)

    name = "both.nii"
    holds(f"nifti/{name}", 1, 0, put(name, array("uint8"), change=both))
    name = "spaced.nii"
    put(name, array("uint8"), place=None, change=lambda h: (h.set_qform(None, 0), h.set_sform(None, 0), h.set_zooms((0.5, 1.5, 2))))
    holds(f"nifti/{name}", 1, 0, affine((0.5, 1.5, 2)))
    name = "extended.nii"
    image = nibabel.Nifti1Image(array("uint8").T, oblique)
    image.header.extensions.append(nibabel.nifti1.Nifti1Extension("comment", b"of some length " * 9))
    nibabel.save(image, str(at / name))
    holds(f"nifti/{name}", 1, 0, image.affine)
    name = "times.nii.gz"
    place = put(name, array("int16", 3, -5, (2,)))
    for frame in [None, 1]:
        holds(f"nifti/{name}", 3, -5 + 180 * (frame or 0), place, frame=frame)
    # Vectors: five axes, one time.
    name = "vectors.nii"
    place = put(name, array("float32", 3, -5, (2, 1)))
    for channel in [None, 1]:
        holds(f"nifti/{name}", 3, -5 + 180 * (channel or 0), place, channel=channel)
    rgb = np.zeros((3, 4, 5), dtype=[("R", "u1"), ("G", "u1"), ("B", "u1")])
    for n, c in enumerate("RGB"):
        rgb[c] = array("uint8", 1, 60 * n)
    name = "rgb.nii"
    place = put(name, rgb)
    for channel in [None, 2]:
        holds(f"nifti/{name}", 1, 60 * (channel or 0), place, channel=channel)
    name = "flat.nii"
    image = nibabel.Nifti1Image(array("uint8")[0].T, oblique)
    nibabel.save(image, str(at / name))
    holds(f"nifti/{name}", 1, 0, image.affine, dims=(5, 4, 1))


def metaimages():
    at = folder("metaimage")
    direction = turned(30) @ np.diag([1, -1, 1.0])
    place = LPS @ affine((0.9, 1.1, 2.5), (10, -20, 30), direction)

    def put(name, data, packed=False, vector=False):
        image = sitk.GetImageFromArray(data, isVector=vector)
        image.SetDirection(direction.ravel().tolist())
        image.SetSpacing((0.9, 1.1, 2.5))
        image.SetOrigin((10, -20, 30))
        sitk.WriteImage(image, str(at / name), packed)

    for dtype in "uint8 int8 int16 uint16 int32 uint32 int64 uint64 float32 float64".split():
        low = -30 if dtype[0] in "if" else 1
        put(f"{dtype}.mha", array(dtype, 2, low), True)
        holds(f"metaimage/{dtype}.mha", 2, low, place)
    for name, packed in [("plain.mha", False), ("plain.mhd", False), ("packed.mhd", True)]:
        put(name, array("int16", 100, -3000), packed)
        holds(f"metaimage/{name}", 100, -3000, place)
    vectors = np.stack([array("float32", 0.5, 10 * n) for n in range(3)], axis=-1)
    put("vectors.mha", vectors, True, True)
    for channel in [None, 1]:
        holds("metaimage/vectors.mha", 0.5, 10 * (channel or 0), place, channel=channel)
    times = sitk.JoinSeries([sitk.GetImageFromArray(array("int16", 3, -5 + 180 * n)) for n in range(2)])
    sitk.WriteImage(times, str(at / "times.mha"))
    for frame in [None, 1]:
        holds("metaimage/times.mha", 3, -5 + 180 * (frame or 0), LPS, frame=frame)
    # VTK's writer, without directions.
    importer = vtk_image(array("uint16", 7, 3), (0.5, 1.5, 2), (1, 2, 3))
    writer = vtk.vtkMetaImageWriter()
    writer.SetInputData(importer)
    writer.SetFileName(str(at / "of_vtk.mhd"))
    writer.SetRAWFileName(str(at / "of_vtk.raw"))
    writer.SetCompression(False)
    writer.Write()
    holds("metaimage/of_vtk.mhd", 7, 3, LPS @ affine((0.5, 1.5, 2), (1, 2, 3)))
    # What no writer at hand writes.
    data = array("<u2", 7, 3)
    head = "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementSpacing = 1 1 2\nElementType = MET_USHORT\n"
    for z in range(3):
        (at / f"slice_{z + 8:02}.raw").write_bytes(data[z].tobytes())
    (at / "numbered.mhd").write_text(head + "ElementDataFile = slice_%02d.raw 8 10 1\n")
    (at / "listed.mhd").write_text(head + "ElementDataFile = LIST\nslice_08.raw\nslice_09.raw\nslice_10.raw\n")
    (at / "planes.mhd").write_text(head + "ElementDataFile = LIST 2D\nslice_08.raw\nslice_09.raw\nslice_10.raw\n")
    (at / "big.mhd").write_text(head + "ElementByteOrderMSB = True\nElementDataFile = big.raw\n")
    (at / "big.raw").write_bytes(data.astype(">u2").tobytes())
    (at / "headed.raw").write_bytes(b"some header" + data.tobytes())
    (at / "at_the_end.mhd").write_text(head + "HeaderSize = -1\nElementDataFile = headed.raw\n")
    (at / "headed.mhd").write_text(head + "HeaderSize = 11\nElementDataFile = headed.raw\n")
    (at / "ascii.mha").write_text(head + "BinaryData = False\nElementDataFile = LOCAL\n" + " ".join(str(n) for n in data.ravel()) + "\n")
    for name in ["numbered.mhd", "listed.mhd", "planes.mhd", "big.mhd", "at_the_end.mhd", "headed.mhd", "ascii.mha"]:
        holds(f"metaimage/{name}", 7, 3, LPS @ affine((1, 1, 2)))


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
    # A grid that does not begin at 0, and is turned.
    turn = turned(40)
    moved = vtk_image(array("float32", 0.5, -7), spacing, origin, first=(3, -2, 7))
    moved.SetDirectionMatrix(*turn.ravel())
    put("moved.vti", moved)
    point = [0.0] * 3
    moved.TransformIndexToPhysicalPoint(3, -2, 7, point)
    holds("vtk/moved.vti", 0.5, -7, affine(spacing, point, turn))
    # Several arrays, one of three components, one in cells.
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
    # As files of 1998 are.
    (at / "legacy_30.vtk").write_text(
        "# vtk DataFile Version 3.0\nby hand\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\nASPECT_RATIO 0.5 1.5 2\n"
        "ORIGIN 1 -2 3\nPOINT_DATA 60\nSCALARS values unsigned_char\nLOOKUP_TABLE default\n"
        + " ".join(str(n) for n in range(60)) + "\n")
    holds("vtk/legacy_30.vtk", 1, 0, place)


def numpys():
    at = folder("numpy")
    for dtype in "uint8 int8 int16 uint16 int32 uint32 int64 uint64 float16 float32 float64 >i2 >f4".split():
        low = -30 if dtype.lstrip(">")[0] in "if" else 1
        name = dtype.replace(">", "big_") + ".npy"
        np.save(at / name, array(dtype, 2, low))
        holds(f"numpy/{name}", 2, low)
    np.save(at / "fortran.npy", np.asfortranarray(array("int16", 100, -3000)))
    holds("numpy/fortran.npy", 100, -3000)
    np.save(at / "flat.npy", array("int16", 100, -3000)[0])
    holds("numpy/flat.npy", 100, -3000, dims=(5, 4, 1))
    times = array("int16", 3, -5, (2, 1)).reshape(2, 3, 4, 5)
    np.save(at / "times.npy", times)
    for frame in [None, 1]:
        holds("numpy/times.npy", 3, -5 + 180 * (frame or 0), frame=frame)
    np.save(at / "colours.npy", np.stack([array("float32", 0.5, 10 * n) for n in range(3)], -1))
    for channel in [None, 1]:
        holds("numpy/colours.npy", 0.5, 10 * (channel or 0), channel=channel)
    np.savez(at / "plain.npz", first=array("uint8"), second=array("int16", 100, -3000))
    np.savez_compressed(at / "packed.npz", first=array("uint8"), second=np.asfortranarray(array("int16", 100, -3000)))
    for name in ["plain.npz", "packed.npz"]:
        holds(f"numpy/{name}", 1, 0)
        holds(f"numpy/{name}", 100, -3000, array="second")
    at = folder("bov")
    (at / "values.bin").write_bytes(b"1234" + array(">f4", 0.5, -7).tobytes())
    (at / "values.bov").write_text(
        "TIME: 1.5\nDATA_FILE: values.bin\nDATA_SIZE: 5 4 3\nDATA_FORMAT: FLOAT\nVARIABLE: density\nDATA_ENDIAN: BIG\n"
        "CENTERING: nodal\nBRICK_ORIGIN: 1. 2. 3.\nBRICK_SIZE: 2. 4.5 4.\nBYTE_OFFSET: 4\n")
    holds("bov/values.bov", 0.5, -7, affine((0.5, 1.5, 2), (1, 2, 3)))
    (at / "zonal.bin").write_bytes(np.stack([array("<i4", 1, 100 * n) for n in range(2)], -1).tobytes())
    (at / "zonal.bov").write_text(
        "DATA_FILE: zonal.bin\nDATA_SIZE: 5 4 3\nDATA_FORMAT: INT\nDATA_ENDIAN: LITTLE\nCENTERING: zonal\n"
        "BRICK_ORIGIN: 0 0 0\nBRICK_SIZE: 5 8 3\nDATA_COMPONENTS: 2\n")
    for channel in [None, 1]:
        holds("bov/zonal.bov", 1, 100 * (channel or 0), affine((1, 2, 1), (0.5, 1, 0.5)), channel=channel)


def tiffs():
    at = folder("tiff")
    for dtype in "uint8 int8 int16 uint16 int32 uint32 float32 float64 uint64 int64 float16".split():
        low = -30 if dtype[0] in "if" else 1
        tifffile.imwrite(at / f"{dtype}.tif", array(dtype, 2, low), photometric="minisblack", metadata=None)
        holds(f"tiff/{dtype}.tif", 2, low)
    data = array("uint16", 7, 3)
    tifffile.imwrite(at / "big_endian.tif", data, byteorder=">", photometric="minisblack", metadata=None)
    tifffile.imwrite(at / "bigtiff.tif", data, bigtiff=True, photometric="minisblack", metadata=None)
    tifffile.imwrite(at / "zlib.tif", data, compression="zlib", predictor=True, photometric="minisblack", metadata=None)
    tifffile.imwrite(at / "strips.tif", data, rowsperstrip=1, photometric="minisblack", metadata=None)
    for name in ["big_endian", "bigtiff", "zlib", "strips"]:
        holds(f"tiff/{name}.tif", 7, 3)
    tiled = np.arange(2 * 16 * 40, dtype="uint16").reshape(2, 16, 40)
    tifffile.imwrite(at / "tiled.tif", tiled, tile=(16, 16), photometric="minisblack", metadata=None)
    holds("tiff/tiled.tif", 1, 0, dims=(40, 16, 2))
    for z in range(3):
        tifffile.imwrite(at / f"slice_{z + 8}.tif", data[z], photometric="minisblack", metadata=None)
    holds("tiff/slice_%d.tif", 7, 3)
    image = np.stack([array("uint16", 7, 3 + 1000 * c) for c in range(2)], 1)
    image = np.stack([image, image + 10000])
    tifffile.imwrite(at / "imagej.tif", image, imagej=True, resolution=(2.0, 2.0), metadata=dict(axes="TZCYX", spacing=2.0, unit="um"))
    tifffile.imwrite(at / "ome.ome.tif", image, metadata=dict(axes="TZCYX", PhysicalSizeX=0.5, PhysicalSizeY=0.5, PhysicalSizeZ=2.0))
    for name, frame, channel in itertools.product(["imagej.tif", "ome.ome.tif"], [None, 1], [None, 1]):
        holds(f"tiff/{name}", 7, 3 + 10000 * (frame or 0) + 1000 * (channel or 0), affine((0.5, 0.5, 2)), frame=frame, channel=channel)
    # As ImageJ writes more than 4 GB: one directory, and pages one after the other.
    tifffile.imwrite(at / "contiguous.tif", array("uint16", 7, 3), imagej=True, truncate=True, metadata=dict(axes="ZYX", spacing=3.0))
    holds("tiff/contiguous.tif", 7, 3, affine((1, 1, 3)))
    rgb = np.stack([array("uint8", 1, 60 * n) for n in range(3)], -1)
    tifffile.imwrite(at / "rgb.tif", rgb, photometric="rgb", metadata=None)
    tifffile.imwrite(at / "planar.tif", np.moveaxis(rgb, -1, 1), photometric="rgb", planarconfig="separate", metadata=None)
    tifffile.imwrite(at / "packed_rgb.tif", rgb, photometric="rgb", compression="zlib", predictor=True, metadata=None)
    for name, channel in itertools.product(["rgb", "planar", "packed_rgb"], [None, 2]):
        holds(f"tiff/{name}.tif", 1, 60 * (channel or 0), channel=channel)
    Image.fromarray(array("uint8", 4, 1)[0]).save(at / "of_pillow.tif", compression="tiff_lzw", save_all=True,
                                                  append_images=[Image.fromarray(p) for p in array("uint8", 4, 1)[1:]])
    holds("tiff/of_pillow.tif", 4, 1)
    at = folder("png")
    for name, dtype in [("bytes", "uint8"), ("words", "uint16")]:
        data = array(dtype, 4, 1)
        (at / name).mkdir()
        for z in range(3):
            Image.fromarray(data[z]).save(at / name / f"slice_{z + 8}.png")
        holds(f"png/{name}", 4, 1)
        holds(f"png/{name}/slice_%d.png", 4, 1)


if __name__ == "__main__":
    shutil.rmtree(HERE, ignore_errors=True)
    HERE.mkdir()
    for make in [nrrds, niftis, metaimages, vtks, numpys, tiffs]:
        make()
    lines = ",\n".join(json.dumps({k: v for k, v in entry.items() if v is not None}) for entry in expected)
    (HERE / "expected.json").write_text(f"[\n{lines}\n]\n")
