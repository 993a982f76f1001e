"""Settings, cameras and transfer functions are copied, pickled and compared."""

import copy
import pickle

import numpy as np
import pytest

import layersplat
from test_pictures import CASES

SETTINGS = [settings for settings, _, _ in CASES] + [
    {"quality": "draft"},
    {"quality": "high", "kernel": "linear", "samples_per_layer": 3, "layer_axis": "z"},
    {"quality": "high", "density": 5},
    {"quality": "high", "kernel": "cubic"},
    {"quality": "paper", "layer_axis": "x"},
    {"algorithm": "axis-sheets", "layer_axis": "y"},
    {"algorithm": "slicing", "step": 0.3},
    {"algorithm": "raycast", "kernel": "bspline"},
    {"blend": "minimum"},
    {"blend": "average", "extinction": "linear", "early_termination": False},
    {"shading": {"ambient": 0.1, "diffuse": 0.3, "specular": 0.7, "power": 3.5, "light": [(1 / 3, 2, 3), (None, 0.1)]}},
    {"shading": {"light": [((1 / 3, 2, 3), 1 / 7, 1 / 3), None]}, "light_space": "camera"},
    {"shading": {"ambient_color": (0.1, 1 / 3, 1), "light": ((1, 2, 3), 1, 0, (1, 1 / 3, 0))}},
    {"shading": {"light": [((1 / 3, 2, 3), 1 / 7, 1 / 3), None]}, "light_grid": "quarter"},
    {"shading": {"light": None}, "shadows": 1 / 3},
    {"shadows": {"forgiveness": 7 / 3}},
    {"shadows": True, "shading": {"power": 3, "light": (1, 2, 3)}, "light_space": "camera"},
    {"shadows": True, "shading": False, "light_grid": "half"},
    {"ambient_occlusion": {"reach": 1 / 3, "gain": 7 / 3}},
    {"kernel": "linear", "gradient": "sobel"},
    {"kernel": "bspline", "gradient": "gaussian:0.7"},
    {"depth_cue": 0.25},
    {"depth_cue": (1 / 3, (1, 0.5, 0.1))},
    {"gradient_opacity": [(0.1, 1), (1 / 3, 0.25), (7, 0)], "unit_distance": 1 / 7},
    {"crop": ((0, 1, 2), (3.5, 4.25, 1 / 3)), "planes": [((1, 2, 3), (0, 0, 1)), ((1 / 3, 0, 0), (1, 1, 0))]},
]

OTHERS = [
    layersplat.Camera((1, 2, 1 / 3), (0, 0, 0), (0, 0, 1), scale=1 / 7),
    layersplat.Camera((1, 2, 3), (0, 0.5, 0), field_of_view=33.3),
    layersplat.Camera.orbit((1, 2, 3), 7, azimuth=12.3, elevation=45.6, roll=7.8, field_of_view=20),
    layersplat.TransferFunction([(0, (0, 0.25, 1)), (1 / 3, (1, 1, 0)), (1 / 3, (1, 0, 0))], [(0, 0), (9, 0.1)], name="mine"),
    layersplat.TransferFunction.builtin("fire", (0.1, 255)).faded(1 / 3),
    layersplat.TransferFunction.automatic(layersplat.Volume(np.arange(27, dtype=np.uint8).reshape(3, 3, 3))),
]

COPIES = [copy.copy, copy.deepcopy] + [lambda thing, p=p: pickle.loads(pickle.dumps(thing, p)) for p in range(pickle.HIGHEST_PROTOCOL + 1)]


@pytest.mark.parametrize("thing", [layersplat.Settings(**arguments) for arguments in SETTINGS] + OTHERS)
def test_copies_are_equal(thing):
    for make in COPIES:
        made = make(thing)
        assert type(made) is type(thing) and made == thing and repr(made) == repr(thing)


def test_different_objects_are_not_equal():
    all_of_them = [layersplat.Settings(**arguments) for arguments in [{}] + SETTINGS[len(CASES) :]] + OTHERS
    for i, one in enumerate(all_of_them):
        assert all(one != other for other in all_of_them[:i]) and one != 3 and one is not None


def test_repr_of_settings_omits_defaults():
    assert repr(layersplat.Settings()) == "layersplat.Settings()"
    shown = repr(layersplat.Settings("high", shading=False, blend=("iso", 3)))
    assert shown.startswith("layersplat.Settings(") and "blend=('iso', 3.0)" in shown and "quality='high'" in shown
    assert eval(shown) == layersplat.Settings("high", shading=False, blend=("iso", 3))
    for arguments in SETTINGS:
        settings = layersplat.Settings(**arguments)
        assert eval(repr(settings)) == settings
    assert "shadows={'strength': 0.5, 'forgiveness': 4.0}" in repr(layersplat.Settings(shadows=0.5))


def test_equal_settings_of_lights():
    """Forms of the same light, and the light that shadows have by default."""
    beside = {"light": [((-1, 1, 1), 1, 0)]}
    equal = [
        ({}, {"shadows": False, "ambient_occlusion": False, "light_space": "camera"}),
        ({"shadows": True}, {"shadows": {}, "shading": True}),
        ({"shadows": True}, {"shadows": 1.0, "shading": beside, "light_space": "camera"}),
        ({"shadows": 0}, {"shadows": {"strength": 0}}),
        ({"ambient_occlusion": True}, {"ambient_occlusion": {"reach": float("inf"), "gain": 3}}),
        ({"shading": {"light": (1, 2, 3)}}, {"shading": {"light": ((1, 2, 3), 1, 0)}}),
    ]
    for one, other in equal:
        assert layersplat.Settings(**one) == layersplat.Settings(**other)
    shadowed = [{"shadows": True}, {"shadows": True, "shading": {"light": None}}, {"shadows": True, "shading": beside}]
    assert all(layersplat.Settings(**one) != layersplat.Settings(**other) for one in shadowed for other in shadowed if one is not other)


def test_a_copy_draws_the_same_picture(array, transfer):
    renderer = layersplat.Renderer(array, transfer)
    camera, settings = renderer.camera(40, azimuth=20), layersplat.Settings("high", blend=("iso", 80.0))
    expected = renderer.render(camera, 40, settings)
    camera, settings, renderer.transfer = pickle.loads(pickle.dumps((camera, settings, transfer)))
    assert np.array_equal(renderer.render(camera, 40, settings), expected)
