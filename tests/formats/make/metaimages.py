"""MetaImage, written with ITK and VTK, and by hand."""
import numpy as np
import SimpleITK as sitk
import vtk

from vtks import vtk_image
from common import LPS, affine, array, folder, holds, turned


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
    # VTK's writer, which writes no directions.
    importer = vtk_image(array("uint16", 7, 3), (0.5, 1.5, 2), (1, 2, 3))
    writer = vtk.vtkMetaImageWriter()
    writer.SetInputData(importer)
    writer.SetFileName(str(at / "of_vtk.mhd"))
    writer.SetRAWFileName(str(at / "of_vtk.raw"))
    writer.SetCompression(False)
    writer.Write()
    holds("metaimage/of_vtk.mhd", 7, 3, LPS @ affine((0.5, 1.5, 2), (1, 2, 3)))
    # Features that neither writer supports.
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
