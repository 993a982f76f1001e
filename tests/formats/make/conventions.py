"""Missing data, packing and axes by the conventions of CF, xarray, ilastik, OME and VTKHDF, by netCDF4, xarray, h5py and zarr-python; MGH, by nibabel."""
import json

import h5py
import netCDF4
import nibabel
import numpy as np
import xarray
import zarr

from common import affine, array, folder, holds

# Voxels that are missing, by their index.
MISSING = [0, 7, 33]


def without(data, fill):
    data = data.copy()
    data.flat[MISSING] = fill
    return data


def netcdf(path, data, dims="zyx", fill=None, written=slice(None), coordinates={}, **attributes):
    with netCDF4.Dataset(path, "w") as file:
        for name, size in zip(dims, data.shape):
            file.createDimension(name, size)
        for name, (numbers, unit) in coordinates.items():
            axis = file.createVariable(name, "f8", (name,))
            axis[:], axis.units = numbers, unit
        values = file.createVariable("values", data.dtype, tuple(dims), fill_value=fill)
        values.set_auto_maskandscale(False)
        values.setncatts(attributes)
        values[written] = data[written]


def missing(at):
    packed = dict(scale_factor=0.5, add_offset=10.0)
    netcdf(at / "packed.nc", without(array("int16", 100, -3000), -9999), fill=-9999, **packed)
    holds("conventions/packed.nc", 50, -1490, missing=MISSING)
    netcdf(at / "unsigned.nc", without(array("uint8", 4, 1), 255).view("int8"), fill=-1, _Unsigned="true")
    holds("conventions/unsigned.nc", 4, 1, missing=MISSING)
    netcdf(at / "listed.nc", without(array("float32", 0.5, -7), -99.9), missing_value=np.array([-99.9, -88.8], "float32"))
    holds("conventions/listed.nc", 0.5, -7, missing=MISSING)
    netcdf(at / "valid.nc", array("int16", 100, -3000), valid_range=np.array([-2900, 2800], "int16"))
    holds("conventions/valid.nc", 100, -3000, missing=[0, 59])
    # The first layer was never written.
    netcdf(at / "unwritten.nc", array("int32", 70000), written=slice(1, None))
    holds("conventions/unwritten.nc", 70000, missing=list(range(20)))


def axes(at):
    data = array("int16", 100, -3000)
    steps = dict(x=(3 + 0.5 * np.arange(5), "m"), y=(-0.25 * np.arange(4), "m"), z=(100 + 200 * np.arange(3), "cm"))
    netcdf(at / "coordinates.nc", data.T, "xyz", coordinates=steps)
    holds("conventions/coordinates.nc", 100, -3000, affine((0.5, -0.25, 2), (3, 0, 1)))
    several = np.stack([np.stack([data + 10000 * t + 5000 * c for c in range(2)]) for t in range(2)])  # t c z y x
    for order in ["tzyxc", "xcytz"]:
        tags = [dict(key=key, typeFlags=dict(t=8, c=1).get(key, 2), resolution=0, description="") for key in order]
        with h5py.File(at / f"tagged_{order}.h5", "w") as file:
            file["values"] = several.transpose(["tczyx".index(key) for key in order])
            file["values"].attrs["axistags"] = json.dumps(dict(axes=tags))
            file["values"].attrs["element_size_um"] = [2, 1.5, 0.5]
        holds(f"conventions/tagged_{order}.h5", 100, 12000, affine((0.5, 1.5, 2)), frame=1, channel=1)
    with h5py.File(at / "scales.h5", "w") as file:
        values = file.create_dataset("values", data=data.T)
        for n, (name, numbers) in enumerate(dict(x=0.5 * np.arange(5), y=1.5 * np.arange(4), z=2 * np.arange(3)).items()):
            file[name] = numbers
            file[name].make_scale(name)
            values.dims[n].attach_scale(file[name])
            values.dims[n].label = name
    holds("conventions/scales.h5", 100, -3000, affine((0.5, 1.5, 2)))


def kinds(at):
    with h5py.File(at / "float16.h5", "w") as file:
        file["values"] = array("float16", 0.5, -7)
    holds("conventions/float16.h5", 0.5, -7)
    with h5py.File(at / "bool.h5", "w", userblock_size=1024) as file:
        file["values"] = np.tile([False, True], (3, 4, 1))
    holds("conventions/bool.h5", dims=(2, 4, 3), strides=[1, 0, 0])
    with h5py.File(at / "lzf.h5", "w") as file:
        file.create_dataset("values", data=array("int32", 3), chunks=(2, 4, 5), compression="lzf", shuffle=True)
    holds("conventions/lzf.h5", 3)
    with h5py.File(at / "never.h5", "w") as file:
        file.create_dataset("values", shape=(3, 4, 5), dtype="float32", fillvalue=2.5)
    holds("conventions/never.h5", 0, 2.5)
    array("int16", 100, -3000).tofile(at / "stored.bin")
    with h5py.File(at / "external.h5", "w") as file:
        file.create_dataset("values", shape=(3, 4, 5), dtype="int16", external=[("stored.bin", 0, 120)])
    with h5py.File(at / "linked.h5", "w") as file:
        file["link"] = h5py.ExternalLink("external.h5", "/values")
    with h5py.File(at / "image.vtkhdf", "w") as file:
        group = file.create_group("VTKHDF")
        group.attrs.update(dict(Version=[2, 0], Type=np.bytes_("ImageData"), WholeExtent=[1, 5, 0, 3, 0, 2], Origin=[7.0, 8, 9],
                                Spacing=[0.5, 1.5, 2], Direction=np.eye(3).ravel()))
        group["PointData/values"] = array("int16", 100, -3000)
        group["PointData/vectors"] = array("float32")[..., None] + [0, 100, 200]
        group["CellData/cells"] = array("int16", 1)[:2, :3, :4]
        group["PointData"].attrs["Scalars"] = np.bytes_("values")
    place = dict(spacing=(0.5, 1.5, 2), origin=(7.5, 8, 9))
    holds("conventions/image.vtkhdf", 100, -3000, affine(**place))
    holds("conventions/image.vtkhdf", 1, 200, affine(**place), array="vectors", channel=2)
    holds("conventions/image.vtkhdf", 1, 0, affine((0.5, 1.5, 2), (7.75, 8.75, 10)), dims=(4, 3, 2), strides=[1, 5, 20], array="cells")


def zarrs(at):
    data = without(array("float64", 50, -1490), np.nan)
    steps = dict(x=0.5 * np.arange(5), y=1.5 * np.arange(4), z=2.0 * np.arange(3))
    encodings = dict(packed=dict(dtype="int16", scale_factor=0.5, add_offset=10.0, _FillValue=-9999), floats=dict(dtype="float32", _FillValue=-9999.0))
    for version in [2, 3]:
        for name, encoding in encodings.items():
            made = xarray.Dataset(dict(values=(("x", "y", "z"), data.T)), coords=steps)
            made.to_zarr(at / f"{name}_{version}.zarr", encoding=dict(values=encoding), zarr_format=version)
            holds(f"conventions/{name}_{version}.zarr/values", 50, -1490, affine((0.5, 1.5, 2)), missing=MISSING)
    several = np.stack([array("uint16", 7, 3 + 1000 * c) for c in range(2)])[None]
    units = dict(t="second", z="nanometer", y="micrometer", x="micrometer")
    axes = [dict(name=name, type=dict(t="time", c="channel").get(name, "space"), unit=units.get(name)) for name in "tczyx"]
    scale = [dict(type="scale", scale=[1, 1, 2000, 1.5, 0.5])]
    for version, more, image in [("0.2", {}, {}), ("0.4", dict(axes=axes), dict(coordinateTransformations=scale))]:
        group = zarr.open_group(at / f"ome_{version}.zarr", mode="w", zarr_format=2)
        group.create_array("0", data=several, chunks=(1, 1, 3, 4, 5))
        group.attrs["multiscales"] = [dict(version=version, datasets=[dict(path="0", **image)], **more)]
        holds(f"conventions/ome_{version}.zarr", 7, 1003, affine((0.5, 1.5, 2) if image else (1, 1, 1)), channel=1)


def mgh(at):
    place = affine((0.5, 1.5, 2), (7, 8, 9), [[-1, 0, 0], [0, 0, 1], [0, -1, 0]])
    times = np.stack([array(">i2", 100, -3000).T, array(">i2", 100, 3000).T], axis=-1)
    for ending in ["mgh", "mgz"]:
        nibabel.save(nibabel.MGHImage(times, place), at / f"frames.{ending}")
        for frame in [None, 1]:
            holds(f"conventions/frames.{ending}", 100, -3000 + 6000 * (frame or 0), place, frame=frame)


def refused(at):
    with h5py.File(at / "external.h5", "w") as file:
        file.create_dataset("values", shape=(3, 4, 5), dtype="int16", external=[("gone.bin", 0, 120)])
    with h5py.File(at / "linked.h5", "w") as file:
        file["link"] = h5py.ExternalLink("gone.h5", "/values")
    layout = h5py.VirtualLayout(shape=(3, 4, 5), dtype="int16")
    layout[:2] = h5py.VirtualSource("linked.h5", "values", shape=(3, 4, 5))[:2]
    layout[2:] = h5py.VirtualSource("gone.h5", "values", shape=(3, 4, 5))[2:]
    with h5py.File(at / "virtual.h5", "w", libver="latest") as file:
        file.create_virtual_dataset("values", layout)
    with h5py.File(at / "poly.vtkhdf", "w") as file:
        file.create_group("VTKHDF").attrs["Type"] = np.bytes_("PolyData")


def conventions():
    at = folder("conventions")
    for write in [missing, axes, kinds, zarrs, mgh]:
        write(at)
    (at / "refused").mkdir()
    refused(at / "refused")
