"""Slices are bit-identical to those of the command, and pixels on voxels have their values."""

import pickle

import numpy as np
import pytest
from PIL import Image

import layersplat

SPACING = (1.2, 0.9, 1.0)


@pytest.fixture
def renderer(array, transfer):
    return layersplat.Renderer(layersplat.Volume(array, SPACING), transfer)


def test_pixels_on_voxels_have_their_values(array):
    renderer = layersplat.Renderer(array)
    for kernel in ["linear", "cubic", "catmull-rom", "bspline"]:
        for axis, expected in [("z", array[7]), ("y", array[:, 7]), ("x", array[:, :, 7])]:
            size = expected.shape[::-1]
            values = renderer.slice_values(layersplat.Slice.at(renderer, size, axis, 7), size, kernel=kernel)
            assert values.dtype == np.float32 and np.abs(values - expected[::-1]).max() < 0.02


def test_the_commands_slices(array, renderer, command, tmp_path):
    file = tmp_path / "volume_28x24x20_uint8.raw"
    array.tofile(file)
    size = (72, 60)
    common = ["slice", file, "--spacing", "1.0,0.9,1.2", "--size", "72x60"]
    slices = [
        (layersplat.Slice.at(renderer, size, "y", 11.25), ["--axis", "y", "--at", "11.25"]),
        (layersplat.Slice.facing(renderer, size, (13, 10, 11), (1, 1, 0.5)), ["--plane", "13,10,11,1,1,0.5", "--up", "y"]),
    ]
    for plane, place in slices:
        command(*common, *place, "--window", "100,150", "--kernel", "bspline", "-o", tmp_path / "grey.png")
        grey = renderer.slice(plane, size, kernel="bspline", window=(100, 150))
        assert np.array_equal(grey, np.asarray(Image.open(tmp_path / "grey.png"))) and grey[..., 0].max() > 100
        colors = ["--transfer", "fire", "--transfer-range", "0,255", "--thickness", "2", "--background", "transparent"]
        command(*common, *place, *colors, "-o", tmp_path / "colors.png")
        found = renderer.slice(plane, size, thickness=2, background="transparent")
        assert np.array_equal(found, np.asarray(Image.open(tmp_path / "colors.png")))
        command(*common, *place, "--values", "-o", tmp_path / "values.npy")
        assert np.array_equal(renderer.slice_values(plane, size), np.load(tmp_path / "values.npy"), equal_nan=True)


def test_slices_are_values(renderer):
    plane = layersplat.Slice.at(renderer, 30, point=(3, 4, 5))
    assert plane.centre == (3, 4, 5) and plane == pickle.loads(pickle.dumps(plane))
    assert plane != layersplat.Slice(plane.centre, plane.right, plane.up, plane.scale * 2)
    assert layersplat.Slice.at(renderer, 30) == layersplat.Slice.at(renderer, 30, "z", 9.5)


def test_bad_slices_name_the_argument(array, renderer):
    at, plane = layersplat.Slice.at, layersplat.Slice.at(renderer, 8)
    for call, field in [
        (lambda: at(renderer, 8, "x", 28), "at"),
        (lambda: at(renderer, 8, "axial"), "axis"),
        (lambda: at(renderer, 8, "front"), "axis"),
        (lambda: at(renderer, 8, "x", 1, point=(1, 1, 1)), "point"),
        (lambda: layersplat.Slice((0, 0, 0), (1, 0, 0), (2, 0, 0), 1), "plane"),
        (lambda: renderer.slice(plane, 8, window=(0, -1)), "window"),
        (lambda: renderer.slice(plane, 8, window=(0, 1), thickness=1), "thickness"),
        (lambda: renderer.slice(plane, 8, kernel="nearest"), "kernel"),
    ]:
        with pytest.raises(layersplat.InvalidValue) as raised:
            call()
        assert raised.value.fields == (field,)
    with pytest.raises(layersplat.InvalidType):
        at(array, 8)
    limited = layersplat.Renderer(array, device=layersplat.Device(memory=200_000))
    with pytest.raises(layersplat.InvalidValue, match="holds the whole volume"):
        limited.slice_values(plane, 8)
