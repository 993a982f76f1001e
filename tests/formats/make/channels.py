"""Channels with names, colours and windows (tifffile, zarr-python), and colours of three and four components, of every format that has them."""
import struct, zlib

import nibabel
import nrrd
import numpy as np
import tifffile
import zarr
from ome_zarr.format import FormatV04, FormatV05
from ome_zarr.writer import write_image

from common import affine, array, folder, holds


def components(dtype, count, step=60):
    """Indexed (z, y, x, component)."""
    return np.stack([array(dtype, 1, step * n) for n in range(count)], axis=-1)


def described(at):
    data = np.stack([array("uint8", 1, 60 * n) for n in range(3)], axis=1)
    tables = [np.stack([np.arange(256) * c // 255 for c in color]).astype("uint8") for color in [(0, 0, 255), (0, 255, 0), (255, 0, 102)]]
    labels = [f"{name}\nz {z}" for z in range(3) for name in ("DAPI", "", "Texas Red")]
    for name, order in [("imagej", "<"), ("imagej_big", ">")]:
        metadata = dict(axes="ZCYX", mode="composite", LUTs=tables, Ranges=(1.0, 200.5, 0.0, 255.0, 9.0, 9.0), Labels=labels, unit="um", spacing=2.0)
        tifffile.imwrite(at / f"{name}.tif", data, imagej=True, byteorder=order, resolution=(2, 2), metadata=metadata)
        for channel in [0, 2]:
            holds(f"channels/{name}.tif", 1, 60 * channel, affine((0.5, 0.5, 2)), channel=channel)
    tifffile.imwrite(at / "grey.tif", array("uint8"), imagej=True, metadata=dict(axes="ZYX", min=3.0, max=50.0))
    holds("channels/grey.tif", 1, 0)
    metadata = dict(axes="ZCYX", Channel=dict(Name=["Hoechst", "a & b", "mCherry"], Color=[65535, -1, -16776961]))
    tifffile.imwrite(at / "named.ome.tif", data, metadata=metadata)
    for channel in [0, 2]:
        holds("channels/named.ome.tif", 1, 60 * channel, channel=channel)
    told = [dict(label="DAPI", color="0000FF", active=True, window=dict(start=10, end=90.5, min=0, max=255)), dict(label="EGFP", active=False)]
    for version, form in [("04", FormatV04()), ("05", FormatV05())]:
        group = zarr.open_group(str(at / f"omero_{version}.zarr"), mode="w", zarr_format=form.zarr_format)
        write_image(data.transpose(1, 0, 2, 3), group, axes="czyx", fmt=form, scale_factors=())
        if version == "04":
            group.attrs["omero"] = dict(channels=told, version="0.4")
        else:
            group.attrs["ome"] = dict(group.attrs["ome"], omero=dict(channels=told, version="0.5"))
        for channel in [0, 2]:
            holds(f"channels/omero_{version}.zarr", 1, 60 * channel, channel=channel)


def png(path, rows):
    """Rows of pixels of 8 or 16 bits: (y, x, component)."""
    height, width, count = rows.shape
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    lines = b"".join(b"\0" + line.astype(rows.dtype.newbyteorder(">")).tobytes() for line in rows)
    header = struct.pack(">IIBBBBB", width, height, 8 * rows.dtype.itemsize, {3: 2, 4: 6}[count], 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b""))


def vti(path, data):
    """ASCII point data: (z, y, x, component)."""
    kind = {"uint8": "UInt8", "uint16": "UInt16", "float32": "Float32"}[data.dtype.name]
    path.write_text(f'<VTKFile type="ImageData" version="1.0"><ImageData WholeExtent="0 4 0 3 0 2" Origin="0 0 0" Spacing="1 1 1">'
                    f'<Piece Extent="0 4 0 3 0 2"><PointData Scalars="colour"><DataArray type="{kind}" Name="colour" '
                    f'NumberOfComponents="{data.shape[-1]}" format="ascii">{" ".join(map(str, data.ravel()))}</DataArray></PointData></Piece>'
                    '</ImageData></VTKFile>\n')


def colours(at):
    for count, name in [(3, "rgb"), (4, "rgba")]:
        for dtype, step in [("uint8", 60), ("uint16", 9000), ("float32", 0.5)]:
            data = components(dtype, count, step)
            extra = dict(extrasamples=["unassalpha"]) if count == 4 else {}
            tifffile.imwrite(at / f"{name}_{dtype}.tif", data, photometric="rgb", **extra)
            np.save(at / f"{name}_{dtype}.npy", data)
            vti(at / f"{name}_{dtype}.vti", data)
            zarr.create_array(store=str(at / f"{name}_{dtype}.zarr"), data=data, zarr_format=2)
            header = {"kinds": [f"{name.upper()}-color"] + ["domain"] * 3, "spacings": [np.nan, 1, 1, 1]}
            nrrd.write(str(at / f"{name}_{dtype}.nrrd"), data.transpose(3, 2, 1, 0), header, index_order="F")
            files = [f"{name}_{dtype}.{ending}" for ending in ("tif", "npy", "vti", "zarr", "nrrd")]
            if dtype != "float32":
                (at / f"{name}_{dtype}").mkdir()
                for z in range(3):
                    png(at / f"{name}_{dtype}" / f"{z}.png", data[z])
                files.append(f"{name}_{dtype}")
            if dtype == "uint8":
                voxels = np.zeros((5, 4, 3), dtype=[(c.upper(), "u1") for c in name])
                for n, c in enumerate(name.upper()):
                    voxels[c] = data[..., n].T
                nibabel.save(nibabel.Nifti1Image(voxels, np.eye(4)), str(at / f"{name}.nii"))
                files.append(f"{name}.nii")
            for file in files:
                for channel in [None] + list(range(count)):
                    holds(f"channels/{file}", 1, step * (channel or 0), channel=channel)


def channels():
    at = folder("channels")
    described(at)
    colours(at)
