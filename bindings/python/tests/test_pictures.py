"""Pictures are bit-identical to those of the command."""

import inspect
import io

import numpy as np
import pytest
from PIL import Image

import layersplat

SIZE = (72, 60)
VIEW = ["--size", "72x60", "--azimuth", "35", "--elevation", "-25", "--roll", "10"]
PLACE = {"azimuth": 35.0, "elevation": -25.0, "roll": 10.0}

CASES = [
    ({}, {}, []),
    ({"quality": "high"}, {}, ["--quality", "high"]),
    ({"quality": "paper"}, {}, ["--quality", "paper"]),
    ({"kernel": "catmull-rom", "samples_per_layer": 2}, {}, ["--kernel", "catmull-rom", "--sublayers", "2"]),
    ({"density": 2, "layer_axis": "y"}, {"azimuth": 0.0, "elevation": 60.0}, ["--lattice", "2", "--layer-axis", "y", "--azimuth", "0", "--elevation", "60"]),
    ({"blend": "maximum", "crop": ((3, 2, 1), (20, 21, 17))}, {}, ["--blend", "maximum", "--crop", "3:20,2:21,1:17"]),
    ({"blend": ("iso", 90.0)}, {}, ["--blend", "iso", "--iso", "90"]),
    ({"shading": False, "unit_distance": 3.0}, {}, ["--shading", "off", "--unit-distance", "3"]),
    ({"shading": {"light": (1, 2, 0.5)}}, {}, ["--light", "1,2,0.5"]),
    ({"shading": {"light": (None, 0.5)}}, {}, ["--light", "camera:0.5"]),
    ({"shading": {"light": [((-1, 0.5, 2), 0.75), None, (1, 0, 0)]}}, {}, ["--light", "-1,0.5,2:0.75", "--light", "camera", "--light", "1,0,0"]),
    ({"shading": {"light": [(1, 2, 0.5), None]}, "light_space": "camera"}, {}, ["--light", "1,2,0.5", "--light", "camera", "--light-space", "camera"]),
    ({"shadows": True}, {}, ["--shadows", "on"]),
    ({"shadows": 0.5, "shading": {"light": ((1, 2, 0.5), 0.75, 10)}}, {}, ["--shadows", "on", "--shadow-strength", "0.5", "--light", "1,2,0.5:0.75:10"]),
    (
        {"shadows": {"strength": 0.75, "forgiveness": 2}, "blend": ("iso", 90.0), "light_grid": "half"},
        {},
        ["--shadows", "on", "--shadow-strength", "0.75", "--shadow-forgiveness", "2", "--blend", "iso", "--iso", "90", "--light-grid", "half"],
    ),
    ({"ambient_occlusion": True}, {}, ["--ambient-occlusion", "on"]),
    (
        {"ambient_occlusion": {"reach": 20}, "shadows": True, "light_grid": "quarter"},
        {},
        ["--ambient-occlusion", "on", "--ao-reach", "20", "--shadows", "on", "--light-grid", "quarter"],
    ),
    ({"kernel": "linear", "gradient": "sobel"}, {}, ["--kernel", "linear", "--gradient", "sobel"]),
    ({"kernel": "bspline", "gradient": "gaussian:0.7"}, {}, ["--kernel", "bspline", "--gradient", "gaussian:0.7"]),
    ({"depth_cue": 0.75}, {}, ["--depth-cue", "0.75"]),
    ({"gradient_opacity": [(2, 0), (9, 0.75)]}, {}, ["--gradient-opacity", "2:0,9:0.75"]),
    ({"planes": [((12, 10, 9), (1, 0.5, 0))]}, {}, ["--clip", "12,10,9,1,0.5,0"]),
    ({}, {"field_of_view": 40.0}, ["--perspective", "40"]),
    ({"algorithm": "raycast", "kernel": "gaussian", "step": 0.7}, {}, ["--algorithm", "raycast", "--kernel", "gaussian", "--step", "0.7"]),
    ({"algorithm": "view-sheets", "sheet_distance": 0.5}, {}, ["--algorithm", "view-sheets", "--sheet-distance", "0.5"]),
]


@pytest.mark.parametrize("settings, place, options", CASES)
def test_the_commands_pictures(array, command, tmp_path, settings, place, options):
    spacing = (1.2, 0.9, 1.0)
    file = tmp_path / "volume_28x24x20_uint8.raw"
    array.tofile(file)
    # Options of the case replace those of VIEW.
    defaults = [option for pair in zip(VIEW[::2], VIEW[1::2]) if pair[0] not in options for option in pair]
    common = [file, "--spacing", "1.0,0.9,1.2", "--up", "y", "--transfer", "fire", "--transfer-range", "0,255", *defaults, *options]
    command("render", *common, "--background", "transparent", "-o", tmp_path / "picture.png")
    command("render", *common, "-o", tmp_path / "picture.npy")
    view = layersplat.volshow(
        array, spacing, (0, 255), "fire", settings=layersplat.Settings(**settings), size=SIZE, background="transparent", **{**PLACE, **place}
    )
    expected = np.asarray(Image.open(tmp_path / "picture.png"))
    assert expected[..., 3].max() > 20
    assert np.array_equal(view.render(), expected)
    floats = view._renderer.render_float(view._camera(), SIZE, view.settings)
    assert floats.dtype == np.float32 and np.array_equal(floats, np.load(tmp_path / "picture.npy"))


LIGHT = {"shading": {"light": (1, 2, 0.5)}}
# Two values of every setting, and what they need beside them.
VALUES = {
    "quality": ("standard", "high", {}),
    "algorithm": ("layered", "raycast", {}),
    "kernel": ("cubic", "linear", {}),
    "samples_per_layer": (1, 2, {}),
    "density": (1, 2, {}),
    "layer_axis": ("auto", "y", {"azimuth": 0.0, "elevation": 46.0}),
    "step": (0.5, 0.7, {"algorithm": "raycast"}),
    "sheet_distance": (1.0, 0.5, {"algorithm": "view-sheets"}),
    "blend": ("composite", "maximum", {}),
    "shading": (True, False, {}),
    "light_space": ("world", "camera", LIGHT),
    "look": ("plain", "studio", {}),
    "sky": ((0.4, 0.4, 0.4), ((0.9, 0.9, 1.0), (0.1, 0.1, 0.1)), {"look": "studio"}),
    "scattering": (0.95, 0.25, {"look": "studio"}),
    "exposure": (0.0, 1.5, {"look": "studio"}),
    "tone": ("shoulder", "none", {"look": "studio", "exposure": 2.0}),
    "shadows": (False, True, LIGHT),
    "ambient_occlusion": (False, True, {}),
    "light_grid": ("full", "half", {**LIGHT, "shadows": True}),
    "gradient": ("sobel", "central", {}),
    "gradient_opacity": (None, [(2, 0), (9, 0.75)], {}),
    "depth_cue": (0.25, 0.75, {}),
    "crop": (None, ((3, 2, 1), (20, 21, 17)), {}),
    "planes": (None, [((12, 10, 9), (1, 0.5, 0))], {}),
    "unit_distance": (None, 3.0, {}),
    "extinction": ("exponential", "linear", {}),
    "early_termination": (True, False, {}),
    "gamma": (1.0, 2.2, {}),
    "pixel_aspect": (1.0, 1.5, {}),
}


@pytest.mark.parametrize("name", inspect.signature(layersplat.Settings).parameters)
def test_every_setting_changes_the_picture(array, name):
    one, other, beside = VALUES[name]
    place = {key: beside[key] for key in ("azimuth", "elevation") if key in beside}
    beside = {key: value for key, value in beside.items() if key not in place}
    all_of_them = [layersplat.Settings(**beside, **{name: value}) for value in (one, other)]
    assert all_of_them[0] != all_of_them[1]
    renderer = layersplat.Renderer(layersplat.Volume(array), layersplat.TransferFunction.builtin("fire", (0.0, 255.0)))
    camera = renderer.camera(40, **{**PLACE, **place})
    one, other = (renderer.render(camera, 40, settings) for settings in all_of_them)
    # Rays end where the rest shows in no picture of 8 bits.
    assert name == "early_termination" or not np.array_equal(one, other)


def test_every_light_option_changes_the_picture(array, picture):
    light = {"light": ((1, 2, 0.5), 1, 0)}
    options = [
        {"shading": light},
        {"shading": light, "light_space": "camera"},
        {"shading": light, "shadows": True},
        {"shading": {"light": ((1, 2, 0.5), 1, 45)}, "shadows": True},
        {"shading": light, "shadows": 0.5},
        {"shading": light, "shadows": {"forgiveness": 1}},
        {"shading": light, "shadows": True, "light_grid": "half"},
        {"shading": light, "ambient_occlusion": True},
        {"shading": light, "ambient_occlusion": {"gain": 1}},
        {"shading": light, "ambient_occlusion": {"gain": 1, "reach": 20}},
    ]
    pictures = [picture(array, settings=layersplat.Settings(**option)) for option in options]
    for i, one in enumerate(pictures):
        assert all(not np.array_equal(one, other) for other in pictures[:i]), options[i]


def test_the_studio_is_the_commands(array, command, tmp_path):
    file = tmp_path / "volume_28x24x20_uint8.raw"
    array.tofile(file)
    given = ["--look", "studio", "--scattering", "0.5", "--exposure", "1", "--tone", "none", "--transfer", "fire", "--transfer-range", "0,255"]
    command("render", file, *VIEW, *given, "-o", tmp_path / "picture.png")
    settings = layersplat.Settings(look="studio", scattering=0.5, exposure=1, tone="none")
    found = layersplat.render(layersplat.Volume.open(file), cmap="fire", clim=(0, 255), size=SIZE, settings=settings, **PLACE)
    assert np.array_equal(found, np.asarray(Image.open(tmp_path / "picture.png").convert("RGBA")))
    assert settings == eval(repr(settings), {"layersplat": layersplat}), repr(settings)
    for wrong, words in [({"sky": (1, 1, 1)}, "belongs to the studio"), ({"look": "stage"}, "unknown look"), ({"look": "studio", "sky": {"up": (0, 0, 0)}}, "other than 0")]:
        with pytest.raises((ValueError, layersplat.Error), match=words):
            layersplat.render(array, settings=layersplat.Settings(**wrong), size=SIZE)


def test_the_automatic_transfer_function_and_the_default_background_are_the_commands(array, command, tmp_path):
    file = tmp_path / "volume_28x24x20_int16.raw"
    (array.astype("<i2") * 11 - 500).tofile(file)
    command("render", file, "--size", "72x60", "--azimuth", "0", "-o", tmp_path / "picture.png")
    found = layersplat.render(array.astype(np.int16) * 11 - 500, size=SIZE, azimuth=0, elevation=0)
    expected = np.asarray(Image.open(tmp_path / "picture.png").convert("RGBA"))
    assert np.array_equal(found, expected)
    opened = layersplat.render(layersplat.Volume.open(file), size=SIZE, azimuth=0, elevation=0)
    assert np.array_equal(opened, expected)


def test_pictures_of_real_volumes_are_the_commands(command, tmp_path, shared):
    file = shared("fuel_64x64x64_uint8.raw.gz")
    command("render", file, *VIEW, "--background", "white", "-o", tmp_path / "picture.png")
    found = layersplat.render(layersplat.Volume.open(file), size=SIZE, background="white", **PLACE)
    assert np.array_equal(found, np.asarray(Image.open(tmp_path / "picture.png").convert("RGBA")))


def test_a_view_shows_itself_and_changes(array, tmp_path):
    view = layersplat.volshow(array, size=SIZE)
    shown = np.asarray(Image.open(io.BytesIO(view._repr_png_())))
    assert shown.shape == (60, 72, 4) and np.array_equal(shown, view.render())
    view.save(tmp_path / "view.png")
    assert np.array_equal(np.asarray(Image.open(tmp_path / "view.png")), shown)
    before = view.render()
    for name, value in [("azimuth", 80.0), ("elevation", -10.0), ("roll", 5.0), ("zoom", 1.5), ("field_of_view", 50.0)]:
        setattr(view, name, value)
        after = view.render()
        assert not np.array_equal(before, after), name
        before = after
    view.size = 33
    assert view.render().shape == (33, 33, 4)
    view.camera = layersplat.Camera((100, 0, 0), (14, 12, 10), (0, 1, 0), scale=20)
    looking = view.render()
    view.set_transfer("viridis", opacity="linear")
    assert view.transfer.name == "viridis" and not np.array_equal(view.render(), looking)


def test_zoom_is_a_smaller_scale(array, transfer):
    framing = layersplat.Framing.of(layersplat.Volume(array), transfer)
    fitted, zoomed = (framing.camera(SIZE, azimuth=20, zoom=zoom) for zoom in (1.0, 2.0))
    assert zoomed.scale == fitted.scale / 2 and zoomed.position == fitted.position
    wide, narrow = (framing.camera(SIZE, field_of_view=60, zoom=zoom).field_of_view for zoom in (1.0, 2.0))
    assert wide == 60 and np.isclose(np.tan(np.radians(narrow / 2)) * 2, np.tan(np.radians(30)))


def test_depths_are_where_the_surface_is():
    """A plane across z, seen along z: its depth is its world distance from the eye, in both projections."""
    ramp = np.broadcast_to(np.arange(24, dtype=np.float32)[:, None, None], (24, 20, 22)).copy()
    transfer = layersplat.TransferFunction.builtin("fire", (0.0, 23.0))
    renderer = layersplat.Renderer(layersplat.Volume(ramp, spacing=2.0, background=0.0), transfer)
    settings = layersplat.Settings(kernel="linear", blend=("iso", 7.25))
    for field_of_view in (None, 30.0):
        camera = renderer.camera(SIZE, azimuth=180.0, field_of_view=field_of_view)
        first, mean = renderer.depths(camera, SIZE, settings)
        assert first.shape == mean.shape == (SIZE[1], SIZE[0]) and first.dtype == mean.dtype == np.float32
        seen = 2 * 7.25 - camera.position[2]
        assert abs(first[30, 36] - seen) < 1e-3 and abs(mean[30, 36] - seen) < 1e-3
        assert abs(first[30, 36] - (seen + 2)) > 1.0 and np.isinf(first[0, 0])
    with pytest.raises(layersplat.InvalidValue, match="composite and iso"):
        renderer.depths(camera, SIZE, layersplat.Settings(blend="maximum"))
