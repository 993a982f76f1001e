"""NRRD, written with pynrrd and ITK, and by hand where they lack a feature."""
import gzip

import nrrd
import numpy as np
import SimpleITK as sitk
from common import LPS, affine, array, folder, holds, turned


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
    # ITK's writer: space left-posterior-superior, oblique, one axis reversed.
    image = sitk.GetImageFromArray(array("float32", 0.5, -7))
    direction = turned(30) @ np.diag([1, -1, 1.0])
    image.SetDirection(direction.ravel().tolist())
    image.SetSpacing((0.9, 1.1, 2.5))
    image.SetOrigin((10, -20, 30))
    sitk.WriteImage(image, str(at / "lps.nrrd"))
    holds("nrrd/lps.nrrd", 0.5, -7, LPS @ affine((0.9, 1.1, 2.5), (10, -20, 30), direction))
    sitk.WriteImage(image, str(at / "lps.nhdr"))
    holds("nrrd/lps.nhdr", 0.5, -7, LPS @ affine((0.9, 1.1, 2.5), (10, -20, 30), direction))
    # Permuted axes, one reversed.
    permuted = np.array([[0, 0, -3.0], [0.5, 0, 0], [0, 2.0, 0]])
    for space, change in [("right-anterior-superior", np.eye(4)), ("LPS", LPS), ("RAS", np.eye(4)),
                          ("left-anterior-superior", np.diag([-1.0, 1, 1, 1])), ("scanner-xyz", np.eye(4))]:
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = permuted, (1, 2, 3)
        header = {"space directions": permuted.T.tolist(), "space origin": [1, 2, 3], "space": space}
        put(f"permuted_{space}.nrrd", array("uint8", 4, 1), encoding="raw", **header)
        holds(f"nrrd/permuted_{space}.nrrd", 4, 1, change @ place)
    # Colours along the first axis.
    rgb = array("uint8", 1, 0, ()).repeat(3).reshape(3, 4, 5, 3) + np.arange(3, dtype="uint8") * 60
    put("rgb.nrrd", rgb, encoding="gzip", kinds=["RGB-color", "domain", "domain", "domain"],
        **{"space directions": [[np.nan] * 3, [1, 0, 0], [0, 1, 0], [0, 0, 2]], "space": "RAS", "space origin": [0, 0, 0]})
    for channel in [None, 0, 2]:
        holds("nrrd/rgb.nrrd", 1, 60 * (channel or 0), affine((1, 1, 2)), channel=channel)
    # Time along the last.
    put("times.nrrd", array("int16", 3, -5, (2,)), encoding="raw", kinds=["domain"] * 3 + ["time"],
        **{"space directions": [[1, 0, 0], [0, 1, 0], [0, 0, 2], [np.nan] * 3], "space": "RAS", "space origin": [0, 0, 0]})
    for frame in [None, 1]:
        holds("nrrd/times.nrrd", 3, -5 + 180 * (frame or 0), affine((1, 1, 2)), frame=frame)
    # Times as ITK writes them: directions of four numbers.
    film = sitk.GetImageFromArray(array("int16", 3, -5, (2,)), isVector=False)
    film.SetSpacing((1, 1, 2, 0.5))
    sitk.WriteImage(film, str(at / "itk_times.nrrd"))
    for frame in [None, 1]:
        holds("nrrd/itk_times.nrrd", 3, -5 + 180 * (frame or 0), affine((1, 1, 2)), frame=frame)
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
