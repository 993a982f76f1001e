"""Arrays of any type, layout and byte order, without unnecessary copies."""

import gc
import pathlib
import warnings
import weakref

import numpy as np
import pytest
import SimpleITK

import layersplat
from layersplat import _arrays


@pytest.mark.parametrize("dtype", ["u1", "i2", "u2", "f4", ">i2", ">u2", ">f4", "f2", "i4", "u4", "f8", "i8", "u8", ">f8", ">i4", ">i8", "g"])
def test_types_look_alike(array, picture, dtype):
    assert np.array_equal(picture(array.astype(dtype)), picture(array))


def test_narrow_signed_and_booleans(array, picture):
    signed = (array // 2).astype(np.int8)
    assert np.array_equal(picture(signed, clim=(0, 127)), picture(array // 2, clim=(0, 127)))
    mask = array > 100
    assert np.array_equal(picture(mask, clim=(0, 1)), picture(mask.astype(np.uint8), clim=(0, 1)))


def test_wide_numbers_keep_their_values(array):
    far = layersplat.Volume(array.astype(np.int64) + 2**40)
    assert far.range == (2.0**40 + array.min(), 2.0**40 + array.max()) and far.dtype == "float32"
    near = layersplat.Volume(array.astype(np.int64) - 10**6)
    assert near.range == (array.min() - 1e6, array.max() - 1e6) and near.dtype == "uint8"


def layouts(array):
    z, y, x = array.shape
    spread = np.full((2 * z, 3 * y, 2 * x), 255, dtype=array.dtype)
    spread[1::2, ::3, 1::2] = array
    yield "with gaps", spread[1::2, ::3, 1::2]
    yield "Fortran", np.asfortranarray(array)
    yield "backwards", array[::-1, ::-1, ::-1].copy()[::-1, ::-1, ::-1]
    yield "transposed", array.transpose(1, 2, 0).copy().transpose(2, 0, 1)
    yield "part", np.pad(array, 3, constant_values=200)[3:-3, 3:-3, 3:-3]
    yield "read only", array
    odd = np.frombuffer(b"\0" + array.tobytes(), dtype=np.uint8, offset=1)
    yield "not aligned", odd.view(array.dtype).reshape(array.shape)


@pytest.mark.parametrize("dtype", ["u1", "f4", ">i2", "i4"])
def test_layouts_look_alike(array, picture, dtype):
    values = array.astype(dtype)
    expected = picture(array)
    for name, laid in layouts(values):
        assert np.array_equal(picture(laid), expected), name


def test_a_broadcast_array(array, picture):
    layer = array[8]
    assert np.array_equal(picture(np.broadcast_to(layer, array.shape)), picture(np.repeat(layer[None], len(array), 0)))


@pytest.mark.parametrize("dtype", ["u1", "i1", "u2", "i2", "f4", ">f4", "i4", "f8"])
def test_arrays_may_change_afterwards(array, dtype):
    """A volume has its own voxels, for every type and layout: later writes have no effect."""
    for values in [(array // 2).astype(dtype), (array // 2).astype(dtype)[:, ::-1, ::2]]:
        volume = layersplat.Volume(values)
        renderer = layersplat.Renderer(volume, layersplat.TransferFunction.builtin("fire", volume))
        camera = renderer.camera(40)
        before = renderer.render(camera, 40)
        values[5:15, 5:15, 3:10] = 100
        assert np.array_equal(layersplat.Renderer(volume, renderer.transfer).render(camera, 40), before)


def writable(array):
    """Arrays whose memory can be written to, regardless of their flags."""
    yield "plain", array.copy()
    locked = array.copy()
    locked.flags.writeable = False
    yield "locked", locked
    yield "read-only view", np.broadcast_to(array.copy(), array.shape)
    yield "bytearray", np.frombuffer(bytearray(array.tobytes()), np.uint8).reshape(array.shape)
    yield "strided", np.lib.stride_tricks.as_strided(array.copy(), writeable=False)
    wide = array.astype(np.int32)
    yield "wide", wide
    yield "boolean", array > 100
    yield "image", SimpleITK.GetImageFromArray(array)


def test_writable_memory_is_copied(array):
    for name, values in writable(array):
        voxels, *_ = _arrays.placed(values, None)
        shown = SimpleITK.GetArrayViewFromImage(values) if name == "image" else values
        assert not np.shares_memory(voxels, shown), name


def read_only(array, folder):
    """Arrays of immutable memory."""
    constant = array.tobytes()
    yield "bytes", np.frombuffer(constant, np.uint8).reshape(array.shape)
    yield "view of bytes", np.frombuffer(memoryview(constant), np.uint8).reshape(array.shape)[::2, ::-1]
    np.save(folder / "volume.npy", array)
    yield "mapped file", np.load(folder / "volume.npy", mmap_mode="r")
    yield "part of a mapped file", np.asarray(np.memmap(folder / "volume.npy", np.uint8, "r", 128, array.shape))[:, 3:]


def test_immutable_memory_is_not_copied(array, picture, tmp_path):
    for name, values in read_only(array, tmp_path):
        voxels, *_ = _arrays.placed(values, None)
        assert np.shares_memory(voxels, values), name
        assert np.array_equal(picture(values), picture(np.array(values))), name


def test_a_mapped_file_stays_open_as_long_as_its_volume(array, picture, tmp_path):
    array.tofile(tmp_path / "volume.raw")
    values = np.memmap(tmp_path / "volume.raw", np.uint8, "r", 0, array.shape)
    mapped, volume = values.base, layersplat.Volume(values)
    with pytest.raises(BufferError):
        mapped.close()
    del values
    assert np.array_equal(picture(volume), picture(array))
    del volume
    gc.collect()
    mapped.close()


def test_a_volume_does_not_hold_an_array_that_it_copied(array):
    values = array.copy()
    alive, volume = weakref.ref(values), layersplat.Volume(values)
    del values
    gc.collect()
    assert alive() is None and volume.shape == array.shape


def test_a_copy_without_memory_is_an_error():
    """More bytes than the address space, by strides of 0."""
    huge = np.broadcast_to(np.uint8(1), (10**6, 10**6, 10**6))
    with pytest.raises(layersplat.OutOfMemory, match="1000000x1000000x1000000 of uint8"):
        layersplat.Volume(huge)


def test_pictures_are_not_copied(array):
    """The array of a picture is a view of the memory that the library wrote."""
    found = layersplat.render(array, size=(30, 20))
    assert found.shape == (20, 30, 4) and found.flags.c_contiguous and found.flags.writeable and not found.flags.owndata


def test_voxels_without_a_value_are_background(array, picture):
    floats = array.astype(np.float32)
    floats[3:6, 4:9, 5:20] = np.nan
    volume = layersplat.Volume(floats)
    assert volume.invalid == 3 * 5 * 15
    masked = np.ma.masked_array(array, np.isnan(floats))
    assert layersplat.Volume(masked).invalid == volume.invalid
    assert np.array_equal(picture(masked), picture(floats))
    assert layersplat.Volume(floats, background=-5).background == -5


def test_spacing_is_in_the_order_of_the_axes(array):
    volume = layersplat.Volume(array, (3.0, 2.0, 1.0))
    assert volume.shape == (20, 24, 28) and volume.spacing == (1.0, 2.0, 3.0)
    assert np.allclose(volume.centre, [13.5, 23.0, 28.5])
    assert layersplat.Volume(array, 0.5).spacing == (0.5,) * 3
    assert layersplat.Volume(array, np.float32([3, 2, 1])).spacing == (1.0, 2.0, 3.0)


def test_orientation_of_the_axes():
    """In a view along -z, x points to the right and y up."""
    values = np.zeros((9, 31, 31), np.uint8)
    values[4, 5:9, 22:26] = 255
    rows, columns = np.nonzero(layersplat.render(values, size=60, azimuth=0, elevation=0, camera=_front())[..., :3].sum(2))
    assert columns.min() > 30 and rows.min() > 30, "x is large, y is small"


def _front():
    return layersplat.Camera((15, 15, 100), (15, 15, 4), (0, 1, 0), scale=16)


@pytest.mark.parametrize(
    "data, spacing, words",
    [
        (np.zeros((3, 4)), None, "2 axes: give three, z, y, x"),
        (np.zeros((3, 4, 5, 3), np.uint8), None, "4 axes"),
        (np.zeros((3, 0, 5), np.uint8), None, "dims"),
        (np.zeros((3, 0, 5), np.int64), None, "dims"),
        (np.zeros((3, 4, 5), complex), None, "complex128"),
        (np.zeros((3, 4, 5), object), None, "object"),
        ("text", None, "axes"),
        (np.zeros((3, 4, 5)), 0.0, "length 0"),
        (np.zeros((3, 4, 5)), (1.0, 2.0), "spacing has the shape"),
        (np.zeros((3, 4, 5)), (1.0, 1.0, np.nan), "non-finite"),
    ],
)
def test_invalid_volumes_are_rejected(data, spacing, words):
    with pytest.raises(ValueError, match=words) as caught:
        layersplat.Volume(data, spacing)
    assert isinstance(caught.value, layersplat.InvalidValue)


def test_one_of_several_volumes_of_a_file(tmp_path):
    small, large = (np.arange(n**3, dtype=np.uint8).reshape(n, n, n) for n in (3, 4))
    file = tmp_path / "several.npz"
    np.savez(file, small=small, large=large)
    assert layersplat.Volume.open(file, array="small").shape == (3, 3, 3)
    assert layersplat.Volume.open(file, array="large").shape == (4, 4, 4)
    with pytest.raises(layersplat.Error, match="small"):
        layersplat.Volume.open(file, array="none")
    frames = tmp_path / "frames.npy"
    # Few voxels along x would be taken for colour channels.
    one = np.arange(125, dtype=np.uint8).reshape(5, 5, 5)
    np.save(frames, np.stack([one, one + 100]))
    assert [layersplat.Volume.open(frames, frame=frame).range for frame in (0, 1)] == [(0, 124), (100, 224)]


def warnings_of(call):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = call()
    return made, [str(warning.message) for warning in caught if warning.category is layersplat.DataWarning]


def test_values_that_floats_cannot_hold_warn(tmp_path):
    values = np.arange(125, dtype=np.float64).reshape(5, 5, 5)
    values[2, 2] = [1e31, -1e31, 1e300, np.inf, np.nan]
    np.save(tmp_path / "values.npy", values)
    for make, invalid in [
        # Doubles of any magnitude are scaled.
        (lambda: layersplat.Volume(values), 2),
        (lambda: layersplat.Volume.open(tmp_path / "values.npy"), 2),
        (lambda: layersplat.Volume(values.astype(np.float32)), 5),
    ]:
        with np.errstate(over="ignore"):
            volume, messages = warnings_of(make)
        expected = f"{invalid} voxels are NaN, infinite or beyond 1e30"
        assert volume.invalid == invalid and any(expected in message for message in messages), (volume, messages)
    assert warnings_of(lambda: layersplat.Volume(np.clip(np.nan_to_num(values), -9, 200)))[1] == []


def test_whole_numbers_that_floats_cannot_tell_apart_warn():
    values = (np.arange(27, dtype=np.uint32) << 26).reshape(3, 3, 3)
    _, messages = warnings_of(lambda: layersplat.Volume(values + 1))
    assert any("rounding errors" in message for message in messages), messages


def test_masked_voxels_do_not_warn(array):
    masked = np.ma.masked_less(array, 9)
    volume, messages = warnings_of(lambda: layersplat.Volume(masked))
    assert volume.invalid == masked.mask.sum() > 0 and messages == []
    holes = np.ma.masked_less(array.astype(np.float32), 9)
    holes[0, 0, 0] = np.inf
    volume, messages = warnings_of(lambda: layersplat.Volume(holes))
    assert len(messages) == 1 and "count as the background" in messages[0]


def test_a_warning_names_the_callers_line_once_and_can_be_an_error():
    values = np.full((3, 3, 3), np.nan)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        for _ in range(3):
            layersplat.Volume(values)
            layersplat.volshow(values, cmap="fire", clim=(0, 1))
    assert [pathlib.Path(warning.filename).name for warning in caught] == ["test_arrays.py"] * 2
    with warnings.catch_warnings():
        warnings.simplefilter("error", layersplat.DataWarning)
        with pytest.raises(layersplat.DataWarning, match="27 voxels"):
            layersplat.Volume(values)
