"""HDF5, by h5py."""
import h5py
import numpy as np

from common import affine, array, folder, holds


def hdf5s():
    at = folder("hdf5")
    for dtype in "uint8 int8 int16 uint16 int32 uint32 int64 uint64 float32 float64 >i2 >f4".split():
        low = -30 if dtype.lstrip(">")[0] in "if" else 1
        name = dtype.replace(">", "big_") + ".h5"
        with h5py.File(at / name, "w") as file:
            file["values"] = array(dtype, 2, low)
        holds(f"hdf5/{name}", 2, low)
    data = array("int16", 100, -3000)
    kinds = dict(chunked=dict(chunks=(2, 3, 4)), gzip=dict(chunks=(2, 4, 5), compression="gzip", shuffle=True, fletcher32=True),
                 lzf=dict(chunks=(1, 4, 5), compression="lzf"))
    for libver in ["earliest", "latest"]:
        for kind, more in kinds.items():
            name = f"{kind}_{libver}.h5"
            with h5py.File(at / name, "w", libver=libver) as file:
                file.create_dataset("a/b/values", data=data, **more)
                file["a/axis"] = np.arange(5.0)
            holds(f"hdf5/{name}", 100, -3000)
    with h5py.File(at / "several.h5", "w") as file:
        file["first"] = array("uint8", 4, 1)
        second = file.create_dataset("deep/second", data=np.stack([data, data + 10000]))
        second.attrs["element_size_um"] = np.array([2, 1.5, 0.5])
        file["flat"] = np.zeros((4, 5))
    holds("hdf5/several.h5", 4, 1, array="first")
    for frame in [None, 1]:
        holds("hdf5/several.h5", 100, -3000 + 10000 * (frame or 0), affine((0.5, 1.5, 2)), array="deep/second", frame=frame)
    # Packed as in the CF conventions for climate data.
    with h5py.File(at / "scaled.nc", "w") as file:
        scaled = file.create_dataset("t", data=data)
        scaled.attrs["scale_factor"], scaled.attrs["add_offset"] = 0.5, 10.0
    holds("hdf5/scaled.nc", 50, -1490)
    with h5py.File(at / "empty.h5", "w") as file:
        file.create_dataset("values", shape=(3, 4, 5), dtype="float32", chunks=(1, 4, 5), fillvalue=2.5)
    holds("hdf5/empty.h5", 0, 2.5)
    # Of these only the refusal is tested.
    (at / "refused").mkdir()
    with h5py.File(at / "refused" / "complex.h5", "w") as file:
        file["k_space"] = np.arange(60).reshape(3, 4, 5).astype("complex64")
