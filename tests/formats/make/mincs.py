"""MINC 2 by h5py, checked with nibabel, and ITK's HDF5 by SimpleITK."""
import h5py
import nibabel
import numpy as np
import SimpleITK

from common import LPS, affine, array, folder, holds, turned

STEPS = dict(x=0.5, y=-1.5, z=2.0)
STARTS = dict(x=7.0, y=8.0, z=9.0)
# Names of axes by their first letters.
NAMES = dict(x="xspace", y="yspace", z="zspace", t="time")


def minc(path, order, values, scaled, stored="int16", valid=(-100, 90), direction=np.eye(3)):
    """`values` along `order`; the first `scaled` axes have ranges of their own, between which numbers are stored as `valid` ones."""
    inner = tuple(range(scaled, values.ndim))
    lo, hi = values.min(axis=inner, keepdims=True), values.max(axis=inner, keepdims=True)
    with h5py.File(path, "w") as file:
        for axis, size in zip(order, values.shape):
            at = file.create_dataset(f"minc-2.0/dimensions/{NAMES[axis]}", data=0).attrs
            at.update(dict(length=np.uint32(size), start=STARTS.get(axis, 0.0), step=STEPS.get(axis, 2.5), spacing=np.bytes_("regular__")))
            if axis != "t":
                at["direction_cosines"] = direction[:, "xyz".index(axis)]
        named = lambda axes: np.bytes_(",".join(NAMES[axis] for axis in axes))
        image = file.create_group("minc-2.0/image/0")
        numbers = values if stored == "float32" else (values - lo) / (hi - lo) * (valid[1] - valid[0]) + valid[0]
        image.create_dataset("image", data=np.round(numbers, 9).astype(stored), chunks=tuple(min(3, size) for size in values.shape), compression="gzip")
        image["image"].attrs.update(dict(dimorder=named(order), valid_range=np.array(valid, float)))
        for name, ends in [("image-min", lo), ("image-max", hi)]:
            image[name] = ends.reshape(values.shape[:scaled])
            image[name].attrs["dimorder"] = named(order[:scaled])
    assert np.allclose(np.asarray(nibabel.load(path).dataobj), values), path


def mincs():
    at = folder("minc")
    values, place = array("float64", 0.5, 10), affine((0.5, 1.5, 2), (7, 8, 9)) @ np.diag([1, -1, 1, 1])
    minc(at / "slices.mnc", "zyx", values, 1)
    holds("minc/slices.mnc", 0.5, 10, place)
    minc(at / "bytes.mnc", "zyx", array("float64", 1, 10), 0, "uint8", (0, 59))
    holds("minc/bytes.mnc", 1, 10, place)
    minc(at / "floats.mnc", "zyx", values, 0, "float32")
    holds("minc/floats.mnc", 0.5, 10, place)
    # Slices are along y and those of two times, on oblique axes.
    direction = turned(30)
    times = np.stack([values, values + 1000]).transpose(0, 2, 1, 3)
    # From slice to slice, values along z grow by 20 steps, and along x by one: 0 to 44 in steps of a half.
    minc(at / "times.mnc", "tyzx", times, 2, "int16", (0, 440), direction)
    turned_place = affine()
    turned_place[:3, :3] = direction @ np.diag(list(STEPS.values()))
    turned_place[:3, 3] = direction @ list(STARTS.values())
    holds("minc/times.mnc", 0.5, 1010, turned_place, frame=1)
    image = SimpleITK.GetImageFromArray(array("int16", 100, -3000))
    vectors = SimpleITK.GetImageFromArray(array("float32")[..., None] + np.array([0, 100, 200], "float32"), isVector=True)
    for name, one in [("itk", image), ("itk_vectors", vectors)]:
        one.SetSpacing((0.5, 1.5, 2)), one.SetOrigin((7, 8, 9)), one.SetDirection(direction.ravel())
        SimpleITK.WriteImage(one, str(at / f"{name}.hdf5"))
    place = LPS @ affine((0.5, 1.5, 2), (7, 8, 9), direction)
    holds("minc/itk.hdf5", 100, -3000, place)
    holds("minc/itk_vectors.hdf5", 1, 200, place, channel=2)
