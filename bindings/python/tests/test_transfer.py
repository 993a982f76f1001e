"""cmap, clim and opacity."""

import matplotlib
import numpy as np
import pytest

import layersplat
from layersplat import TransferFunction, transfer_function


@pytest.fixture
def volume(array):
    return layersplat.Volume(array)


def test_the_default_is_automatic_and_a_number_scales(volume):
    automatic = TransferFunction.automatic(volume)
    assert transfer_function(volume) == automatic
    half = transfer_function(volume, opacity=0.5)
    assert half.colors == automatic.colors and half.opacities == automatic.faded(0.5).opacities
    assert max(opacity for _, opacity in transfer_function(volume, opacity=1e6).opacities) == 1.0


def test_names_and_limits(volume):
    lo, hi = volume.range
    for name in ["grey", "fire", "viridis", "cool-warm"]:
        assert transfer_function(volume, name) == TransferFunction.builtin(name, volume)
        assert transfer_function(volume, name, (50, 90)) == TransferFunction.builtin(name, (50, 90))
    assert TransferFunction.builtin("fire", (lo, hi)) == TransferFunction.builtin("fire", volume)
    own = TransferFunction.builtin("fire", (3, 9))
    assert transfer_function(volume, own) == own and transfer_function(volume, own, (1, 2)).range == (1, 2)


def test_maps_of_matplotlib(volume):
    magma = matplotlib.colormaps["magma"]
    found = transfer_function(volume, magma, (50, 150))
    for t in [0.0, 0.2, 0.5, 1.0]:
        assert np.allclose(found.color(50 + 100 * t), magma(t)[:3], atol=0.01)
    assert found.name == "magma" and found.opacities == TransferFunction.builtin("grey", (50, 150)).opacities
    listed = matplotlib.colors.ListedColormap(["red", "blue"])
    assert transfer_function(volume, listed, (0, 1)).color(0.9) == (0.0, 0.0, 1.0)
    assert transfer_function(volume, lambda t: np.stack([t, t, 0 * t], -1), (0, 1)).color(0.5) == pytest.approx((0.5, 0.5, 0.0))


def test_lists_of_colours(volume):
    found = transfer_function(volume, ["#ff0000", (0, 1, 0), np.array([0, 0, 1.0])], (0, 10))
    assert found.colors == [(0.0, (1.0, 0.0, 0.0)), (5.0, (0.0, 1.0, 0.0)), (10.0, (0.0, 0.0, 1.0))]
    assert transfer_function(volume, [(1, 0, 0)]).color(70) == (1.0, 0.0, 0.0)


def test_opacities(volume):
    linear = transfer_function(volume, "fire", (10, 20), "linear")
    assert linear.opacities == [(10, 0), (20, 1)]
    points = transfer_function(volume, "fire", (10, 20), [(12, 0.1), (13, 0.7)])
    assert points.opacities == [(12, 0.1), (13, 0.7)] and points.range == (10, 20)
    sampled = transfer_function(volume, "fire", (10, 20), np.array([0, 0.5, 0.2]))
    assert sampled.opacities == [(10, 0), (15, 0.5), (20, 0.2)]
    assert transfer_function(volume, opacity="linear").opacities == [(volume.range[0], 0), (volume.range[1], 1)]


@pytest.mark.parametrize(
    "arguments, words",
    [
        ({"cmap": "pink"}, "unknown transfer function 'pink'"),
        ({"cmap": []}, "give at least one colour"),
        ({"cmap": ["#12345"]}, "is not a colour"),
        ({"cmap": [(1, 2)]}, "is not a colour"),
        ({"cmap": [(1, 2, 3)]}, "entries from 0 to 1"),
        ({"cmap": lambda t: t}, "expected one colour each"),
        ({"clim": (3, 3)}, "LO below HI"),
        ({"opacity": "steep"}, "unknown opacity 'steep'"),
        ({"opacity": -1}, "at least 0"),
        ({"opacity": float("nan")}, "at least 0"),
        ({"opacity": [(1, 2, 3)]}, "shape"),
        ({"opacity": [(5, 0.1), (4, 0.2)]}, "sorted by value"),
        ({"opacity": [(5, 1.1)]}, "from 0 to 1"),
    ],
)
def test_invalid_arguments_are_reported(volume, arguments, words):
    with pytest.raises(layersplat.InvalidValue, match=words):
        transfer_function(volume, **arguments)


def test_a_file_of_paraview(volume, tmp_path):
    file = tmp_path / "map.json"
    file.write_text('[{"Name": "two", "RGBPoints": [0, 1, 0, 0, 100, 0, 0, 1], "Points": [0, 0, 0.5, 0, 100, 1, 0.5, 0]}]')
    found = transfer_function(volume, file)
    assert found.color(100) == (0, 0, 1) and found.range == (0, 100) and transfer_function(volume, str(file)) == found
    with pytest.raises(layersplat.FileError):
        transfer_function(volume, tmp_path / "missing.json")
