"""NumPy arrays, and BOV written by hand."""
import numpy as np
from common import affine, array, folder, holds


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
