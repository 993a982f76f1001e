"""Classic NetCDF by netCDF4, whose readers also give the values."""
import netCDF4
import numpy as np

from common import affine, array, folder, holds


def classic(path, version, times, dims="zyx", unlimited=True, beside=False, **packing):
    """`times`: values of each time along z, y and x."""
    with netCDF4.Dataset(path, "w", format=version) as file:
        file.title = "odd"
        file.createDimension("t", None if unlimited else len(times))
        for name, size in zip("xyz", (5, 4, 3)):
            file.createDimension(name, size)
        if beside:
            steps = dict(t=(2.5 * np.arange(len(times)), "s"), x=(7 + 0.5 * np.arange(5), "m"), y=(8 - 1.5 * np.arange(4), "m"),
                         z=(900 + 200 * np.arange(3), "cm"))
            for name, (numbers, unit) in steps.items():
                axis = file.createVariable(name, "f4", (name,))
                axis[:], axis.units = numbers, unit
            # Records of odd sizes lie between those of the values.
            file.createVariable("odd", "i1", ("t", "y", "z", "x"))[:] = np.ones((len(times), 4, 3, 5))
        values = file.createVariable("values", times.dtype, ("t", *dims), fill_value=packing.pop("fill", None))
        values.set_auto_maskandscale(False)
        values.setncatts(packing)
        values[:] = times.transpose(0, *(1 + "zyx".index(name) for name in dims))


def netcdfs():
    at = folder("netcdf")
    times = lambda dtype: np.stack([array(dtype), array(dtype, 1, 60)])
    classic(at / "bytes.nc", "NETCDF3_CLASSIC", times("int8"))
    holds("netcdf/bytes.nc", 1, 60, frame=1)
    classic(at / "records.nc", "NETCDF3_64BIT_OFFSET", np.stack([array("float64", 0.5, -7), array("float64", 0.5, 93)]), "yzx", beside=True)
    place = affine((0.5, -1.5, 2), (7, 8, 9))
    holds("netcdf/records.nc", 0.5, 93, place, array="values", frame=1)
    classic(at / "fixed.nc", "NETCDF3_64BIT_DATA", times("uint64"), "xyz", unlimited=False)
    holds("netcdf/fixed.nc", 1, 60, frame=1)
    packed = array("int16", 100, -3000)
    packed.flat[[0, 7, 33]] = -9999
    classic(at / "packed.nc", "NETCDF3_CLASSIC", packed[None], fill=-9999, scale_factor=0.5, add_offset=10.0)
    holds("netcdf/packed.nc", 50, -1490, missing=[0, 7, 33])
    (at / "refused").mkdir()
    with netCDF4.Dataset(at / "refused/minc1.mnc", "w", format="NETCDF3_CLASSIC") as file:
        for name, size in dict(zspace=2, yspace=2, xspace=2).items():
            file.createDimension(name, size)
        file.createVariable("image", "i1", ("zspace", "yspace", "xspace"))[:] = np.zeros((2, 2, 2))
        file.createVariable("image-max", "f8", ("zspace",))[:] = [1, 2]
