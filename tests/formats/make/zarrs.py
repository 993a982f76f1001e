"""Zarr versions 2 and 3, written with zarr-python; OME-Zarr, written with ome-zarr, and metadata of several versions by hand."""
import numpy as np
import zarr
from numcodecs import BZ2, LZ4, Blosc, Delta, GZip, Quantize, Shuffle, Zlib, Zstd
from ome_zarr.scale import Methods
from ome_zarr.writer import write_image
from zarr.codecs import BloscCodec, BytesCodec, Crc32cCodec, GzipCodec, ShardingCodec, TransposeCodec, ZstdCodec

from common import affine, array, folder, holds


def put(path, data, version, chunks, **more):
    made = zarr.create_array(store=str(path), shape=data.shape, dtype=data.dtype, chunks=chunks, zarr_format=version, **more)
    made[...] = data
    return made


def second(at):
    data = array("int16", 100, -3000)
    for dtype in "uint8 int8 int16 uint16 int32 uint32 int64 uint64 float16 float32 float64 >i2 >f4".split():
        low = -30 if dtype.lstrip(">")[0] in "if" else 1
        name = dtype.replace(">", "big_")
        put(at / f"{name}.zarr", array(dtype, 2, low), 2, (2, 4, 5), compressors=Zstd(level=3))
        holds(f"zarr/{name}.zarr", 2, low)
    packings = dict(plain=None, gzip=GZip(5), zlib=Zlib(1), zstd=Zstd(level=1))
    packings["lz4"] = LZ4()
    for cname in ["blosclz", "lz4", "lz4hc", "zlib", "zstd"]:
        for shuffle, kind in [(Blosc.NOSHUFFLE, ""), (Blosc.SHUFFLE, "_bytes"), (Blosc.BITSHUFFLE, "_bits")]:
            packings[f"blosc_{cname}{kind}"] = Blosc(cname=cname, clevel=5, shuffle=shuffle)
    for name, packing in packings.items():
        put(at / f"{name}.zarr", data, 2, (2, 4, 5), compressors=packing)
        holds(f"zarr/{name}.zarr", 100, -3000)
    # Blocks that Blosc splits, and a remainder block.
    long = np.arange(3 * 40 * 50, dtype="int32").reshape(3, 40, 50)
    for name, packing in [("split", Blosc(cname="lz4", shuffle=1, blocksize=4096)), ("split_bits", Blosc(cname="zstd", shuffle=2, blocksize=4096)),
                          ("split_blosclz", Blosc(cname="blosclz", shuffle=1, clevel=9))]:
        put(at / f"{name}.zarr", long, 2, (2, 40, 50), compressors=packing)
        holds(f"zarr/{name}.zarr", 1, 0, dims=(50, 40, 3))
    put(at / "fortran.zarr", data, 2, (2, 3, 4), order="F", compressors=None)
    holds("zarr/fortran.zarr", 100, -3000)
    put(at / "slashes.zarr", data, 2, (1, 4, 5), compressors=None, chunk_key_encoding=dict(name="v2", separator="/"))
    holds("zarr/slashes.zarr", 100, -3000)
    zarr.create_array(store=str(at / "empty.zarr"), shape=(3, 4, 5), dtype="float32", chunks=(2, 2, 2), zarr_format=2, fill_value=2.5)
    holds("zarr/empty.zarr", 0, 2.5)
    for name, filters in [("delta", [Delta(dtype="<i2")]), ("shuffle", [Shuffle(elementsize=2)]), ("delta_shuffle", [Delta(dtype="<i2"), Shuffle(2)])]:
        put(at / f"filter_{name}.zarr", data, 2, (2, 3, 4), filters=filters, compressors=Zlib(1))
        holds(f"zarr/filter_{name}.zarr", 100, -3000)
    put(at / "filter_quantize.zarr", array("float32", 0.5, -7), 2, (2, 3, 4), filters=[Quantize(digits=2, dtype="<f4")], compressors=None)
    holds("zarr/filter_quantize.zarr", 0.5, -7)
    put(at / "bz2_alone.zarr", data, 2, (2, 3, 4), compressors=BZ2())


def third(at):
    data = array("int16", 100, -3000)
    packings = dict(plain=[], gzip=[GzipCodec()], zstd=[ZstdCodec(checksum=True)], blosc=[BloscCodec(cname="lz4", shuffle="shuffle", typesize=2)],
                    checked=[ZstdCodec(), Crc32cCodec()], inside=[Crc32cCodec(), GzipCodec()])
    for name, packing in packings.items():
        put(at / f"3_{name}.zarr", data, 3, (2, 3, 4), compressors=packing)
        holds(f"zarr/3_{name}.zarr", 100, -3000)
    for name, endian in [("big", "big"), ("little", "little")]:
        put(at / f"3_{name}.zarr", array("float32", 0.5, -7), 3, (2, 3, 4), serializer=BytesCodec(endian=endian), compressors=None)
        holds(f"zarr/3_{name}.zarr", 0.5, -7)
    put(at / "3_turned.zarr", data, 3, (2, 3, 4), filters=[TransposeCodec(order=(1, 2, 0))], compressors=None)
    holds("zarr/3_turned.zarr", 100, -3000)
    put(at / "3_dots.zarr", data, 3, (2, 3, 4), chunk_key_encoding=dict(name="default", separator="."))
    holds("zarr/3_dots.zarr", 100, -3000)
    put(at / "3_named.zarr", np.moveaxis(np.stack([data, data + 10000]), 0, -1).transpose(2, 1, 0, 3), 3, (2, 3, 4, 1),
        dimension_names=["x", "y", "z", "channel"])
    for channel in [None, 1]:
        holds("zarr/3_named.zarr", 100, -3000 + 10000 * (channel or 0), channel=channel)
    for location in ["start", "end"]:
        sharded = ShardingCodec(chunk_shape=(1, 2, 5), codecs=[BytesCodec(), ZstdCodec()], index_location=location)
        put(at / f"3_shards_{location}.zarr", data, 3, (2, 4, 5), serializer=sharded, compressors=None)
        holds(f"zarr/3_shards_{location}.zarr", 100, -3000)
    put(at / "3_several.zarr/images/second", array("uint8", 4, 1), 3, (2, 3, 4))
    put(at / "3_several.zarr/first", data, 3, (2, 3, 4))
    zarr.open_group(str(at / "3_several.zarr"), mode="a", zarr_format=3)
    zarr.open_group(str(at / "3_several.zarr/images"), mode="a", zarr_format=3)
    holds("zarr/3_several.zarr", 100, -3000)
    holds("zarr/3_several.zarr", 4, 1, array="images/second")
    holds("zarr/3_several.zarr/images/second", 4, 1)


def ome(at):
    # ome-zarr's writer: two time points, two channels, two resolutions, in versions 0.4 and 0.5.
    image = np.stack([np.stack([array("uint16", 7, 3 + 1000 * c + 10000 * t) for c in range(2)]) for t in range(2)])
    for version, name in [(2, "ome_04"), (3, "ome_05")]:
        group = zarr.open_group(str(at / f"{name}.zarr"), mode="w", zarr_format=version)
        write_image(image, group, axes="tczyx", scale_factors=(2,), method=Methods.NEAREST, storage_options=dict(chunks=(1, 1, 2, 4, 5)),
                    scale=dict(z=2, y=0.5, x=0.5))
        for frame, channel in [(None, None), (1, None), (1, 1)]:
            holds(f"zarr/{name}.zarr", 7, 3 + 10000 * (frame or 0) + 1000 * (channel or 0), affine((0.5, 0.5, 2)), frame=frame, channel=channel)
        told = group.attrs["multiscales"] if version == 2 else group.attrs["ome"]["multiscales"]
        told = told[0]["datasets"][1]
        coarse = zarr.open(str(at / f"{name}.zarr" / told["path"]), mode="r")[0, 0]
        # The values show which voxels the writer selected for the coarse level.
        number = (coarse.astype(float) - 3) / 7
        steps = [float(number.take(1, axis=2 - axis).ravel()[0] - number.ravel()[0]) for axis in range(3)]
        scale, moved = [step[step["type"]][:1:-1] for step in told["coordinateTransformations"]]
        holds(f"zarr/{name}.zarr", 7, 3 + 7 * number.ravel()[0], affine(scale, moved), dims=coarse.shape[::-1], strides=steps, level=1)
    # Transforms written by hand, of one level and of all levels; only spatial axes, as version 0.4 writes them.
    group = zarr.open_group(str(at / "ome_moved.zarr"), mode="w", zarr_format=2)
    put(at / "ome_moved.zarr/fine", array("uint8", 4, 1), 2, (2, 3, 4))
    put(at / "ome_moved.zarr/coarse", array("uint8", 4, 1)[:, ::2, ::2], 2, (2, 3, 4))
    moved = [dict(type="scale", scale=[2, 1, 1]), dict(type="translation", translation=[1, 0, 3])]
    group.attrs["multiscales"] = [dict(
        version="0.4", axes=[dict(name=n, type="space", unit="micrometer") for n in "zyx"],
        coordinateTransformations=[dict(type="scale", scale=[1, 0.5, 0.5])],
        datasets=[dict(path="fine", coordinateTransformations=moved),
                  dict(path="coarse", coordinateTransformations=[dict(type="scale", scale=[2, 2, 2])])])]
    holds("zarr/ome_moved.zarr", 4, 1, affine((0.5, 0.5, 2), (1.5, 0, 1)))
    holds("zarr/ome_moved.zarr", 4, 1, affine((1, 1, 2)), dims=(3, 2, 3), strides=[2, 10, 20], level=1)
    # As bioformats2raw writes: a group of images.
    group = zarr.open_group(str(at / "ome_images.zarr"), mode="w", zarr_format=2)
    group.attrs["bioformats2raw.layout"] = 3
    for n in range(2):
        write_image(array("uint8", 4, 1 + n), zarr.open_group(str(at / f"ome_images.zarr/{n}"), mode="w", zarr_format=2), axes="zyx",
                    scale_factors=(), scale=dict(z=3, y=1, x=1))
        holds("zarr/ome_images.zarr", 4, 1 + n, affine((1, 1, 3)), array=str(n) if n else None)


def zarrs():
    at = folder("zarr")
    second(at)
    third(at)
    ome(at)
