"""TIFF, written with tifffile and Pillow, and PNG slices."""
import itertools

import numpy as np
import tifffile
from PIL import Image
from common import affine, array, folder, holds


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
    # As ImageJ writes more than 4 GB: one directory, followed by contiguous pages.
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
