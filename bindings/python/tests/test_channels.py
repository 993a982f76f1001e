"""Several channels, colours and labels."""

import json

import numpy as np
import pytest

import layersplat
from layersplat import Channel, Colors, Labels, Renderer

SIZE = (48, 40)
VIEW = {"size": SIZE, "azimuth": 25, "quality": "draft"}
ROUNDING = 1
"""Largest difference of two pictures in 8 bits whose floats differ in the last digits."""


def ball(centre, shape=(16, 18, 20), radius=5.0):
    """(z, y, x), float32: 1 at the centre, 0 from the radius on."""
    grid = np.mgrid[tuple(slice(n) for n in shape)].astype(np.float32)
    distance = np.sqrt(sum((axis - c) ** 2 for axis, c in zip(grid, centre)))
    return (1 - distance / radius).clip(0).astype(np.float32)


@pytest.fixture(scope="module")
def arrays():
    return [ball((8, 9, 5)), ball((8, 9, 14))]


def mean_color(picture, half):
    """The mean colour of the left (0) or right (1) half of a picture from the front."""
    middle = picture.shape[1] // 2
    return (picture[:, :middle] if half == 0 else picture[:, middle:])[..., :3].reshape(-1, 3).mean(0)


def test_channels_are_drawn_together_in_separate_colours(arrays):
    picture = layersplat.render(arrays, size=SIZE, azimuth=0, elevation=0, quality="draft")
    (r, g, b), (r2, g2, b2) = mean_color(picture, 0), mean_color(picture, 1)
    assert g > 5 * max(r, b, 0.1) and min(r2, b2) > 5 * max(g2, 0.1), "green on the left, magenta on the right"
    single = layersplat.render(arrays[:1], size=SIZE, azimuth=0, elevation=0, quality="draft")
    assert (single[..., 0] == single[..., 1]).all() and single[..., :3].max() > 20, "white"


def test_all_forms_of_channels_draw_the_same(arrays):
    xarray = pytest.importorskip("xarray")
    expected = layersplat.render(arrays, **VIEW)
    assert expected[..., :3].max() > 20
    stacked = np.stack(arrays)
    for axis in (0, 3, -1):
        found = layersplat.render(np.moveaxis(stacked, 0, axis), channel_axis=axis, **VIEW)
        assert (found == expected).all(), axis
    volumes = [layersplat.Volume(array) for array in arrays]
    assert (layersplat.render(volumes, **VIEW) == expected).all()
    assert (layersplat.render(layersplat.channels(arrays), **VIEW) == expected).all()
    for name in ("c", "channel"):
        array = xarray.DataArray(stacked, dims=(name, "z", "y", "x"))
        assert (layersplat.render(array, **VIEW) == expected).all(), name


def test_names_of_an_xarray_give_colours(arrays):
    xarray = pytest.importorskip("xarray")
    array = xarray.DataArray(np.stack(arrays), dims=("c", "z", "y", "x"), coords={"c": ["DAPI", "other"]})
    first, second = layersplat.channels(array)
    assert first.transfer.color(1.0)[2] > max(first.transfer.color(1.0)[:2])
    assert first.volume.name == "DAPI" and second.transfer.color(1.0) == (0.0, 1.0, 0.0)


def test_one_channel_is_the_picture_of_its_volume(arrays, transfer):
    transfer = transfer.stretched(0.0, 1.0)
    camera = Renderer(arrays[0], transfer).camera(SIZE, azimuth=30)
    expected = Renderer(arrays[0], transfer).render_float(camera, SIZE)
    assert expected.max() > 0.1
    found = Renderer([Channel(arrays[0], transfer)]).render_float(camera, SIZE)
    assert (found == expected).all()
    # Two halves are the whole, and a hidden channel is nothing.
    halves = Renderer([Channel(arrays[0], transfer, factor=0.5)] * 2).render_float(camera, SIZE)
    assert np.abs(halves - expected).max() < 1e-4
    hidden = Renderer([Channel(arrays[0], transfer), Channel(arrays[1], transfer, visible=False)])
    assert (hidden.render_float(camera, SIZE) == expected).all()
    # The test notices a factor that is ignored.
    assert np.abs(Renderer([Channel(arrays[0], transfer, factor=0.5)]).render_float(camera, SIZE) - expected).max() > 1e-2


def test_channels_are_replaced_and_keep_their_voxels():
    arrays = [ball((32, 32, x), (64, 64, 64), 20.0) for x in (20, 44)]
    channels = layersplat.channels(arrays)
    device = layersplat.Device()
    renderer = Renderer(channels, device=device)
    camera = renderer.camera(SIZE, azimuth=30)
    before = renderer.render(camera, SIZE)
    first = device.allocated_bytes
    changed = [channels[0].replaced(factor=3.0), channels[1].replaced(visible=False)]
    renderer.set_volume(changed)
    after = renderer.render(camera, SIZE)
    assert device.allocated_bytes < first + arrays[0].nbytes, "a second copy of the voxels"
    assert (after != before).any() and (after == Renderer(changed, device=device).render(camera, SIZE)).all()
    renderer.set_volume(channels)
    assert (renderer.render(camera, SIZE) == before).all()
    # On another device they are uploaded anew.
    assert (Renderer(channels).render(camera, SIZE) == before).all()


def test_channels_of_a_file_are_opened_with_its_colours(tmp_path, arrays):
    # OME-Zarr, uncompressed, with the metadata of two channels.
    (tmp_path / "0").mkdir()
    stacked = np.stack([(255 * array).astype(np.uint8) for array in arrays])
    stacked.tofile(tmp_path / "0" / "0.0.0.0")
    shape = list(stacked.shape)
    array = {"zarr_format": 2, "shape": shape, "chunks": shape, "dtype": "|u1", "order": "C", "compressor": None, "fill_value": 0}
    axes = [{"name": name, "type": "channel" if name == "c" else "space"} for name in "czyx"]
    sets = [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1, 1]}]}]
    stated = [{"label": "one", "color": "FF0000", "window": {"start": 10, "end": 90, "min": 0, "max": 255}}, {"active": False}]
    group = {"multiscales": [{"version": "0.4", "axes": axes, "datasets": sets}], "omero": {"channels": stated}}
    for name, metadata in {"0/.zarray": {**array, "filters": None}, ".zattrs": group, ".zgroup": {"zarr_format": 2}}.items():
        (tmp_path / name).write_text(json.dumps(metadata))
    one, two = Channel.open(tmp_path)
    assert one.transfer.color(50) == (1.0, 0.0, 0.0) and one.transfer.range == (10.0, 90.0)
    assert (one.visible, two.visible) == (True, False) and one.volume.range == (0.0, stacked[0].max())
    assert layersplat.render([one, two], **VIEW)[..., 0].max() > 20


def test_options_of_channels(arrays):
    one, two = layersplat.channels(arrays, color=["#ff0000", None], clim=[(0.2, 0.8), None], factor=[2, None], visible=[True, False])
    assert one.transfer.color(0.5) == (1.0, 0.0, 0.0) and one.transfer.range == (0.2, 0.8)
    assert (one.factor, two.factor, one.visible, two.visible) == (2.0, 1.0, True, False)
    assert "hidden" in repr(two)
    picture = layersplat.render(arrays, factor=[3, 1], visible=[True, False], names=["DAPI", None], **VIEW)
    assert picture[..., 2].max() > 20 and picture[..., 2].sum() > 1.5 * picture[..., 0].sum(), "blue"
    [ramp] = layersplat.channels(arrays[:1], blend="maximum")
    assert ramp.transfer.color(ramp.transfer.range[0]) == (0.0, 0.0, 0.0)
    [named] = layersplat.channels(arrays[:1], cmap=["viridis"])
    assert named.transfer.name == "viridis"


def test_colors_are_drawn_as_they_are(arrays, tmp_path):
    red, alpha = np.full_like(arrays[0], 255), 255 * arrays[0]
    rgba = np.stack([red, 0 * red, 0 * red, alpha], -1).astype(np.uint8)
    picture = layersplat.render(rgba, colors="direct", shade=False, **VIEW)
    assert picture[..., 0].max() > 100 and picture[..., 1:3].max() <= ROUNDING
    # Components of another order have another colour, and floats are the same.
    blue = layersplat.render(rgba[..., [1, 2, 0, 3]], colors="direct", shade=False, **VIEW)
    assert (blue[..., 2] == picture[..., 0]).all()
    floats = layersplat.render(rgba.astype(float) / 255, colors="direct", shade=False, **VIEW)
    assert np.abs(floats.astype(int) - picture).max() <= ROUNDING
    rgb = (255 * np.stack([arrays[0]] * 3, -1)).astype(np.uint8)
    assert layersplat.render(rgb, colors="direct", **VIEW).max() > 20
    # White voxels are transparent.
    inverse = layersplat.render(Colors(255 - rgb, opacity=(1.0, 1.0, 1.0)), **VIEW)
    assert inverse[0, 0, :3].max() == 0 and inverse[..., :3].max() > 0
    assert Colors(rgba).shape == (16, 18, 20, 4)
    header = b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 20 18 16\nkinds: RGBA-color domain domain domain\nencoding: raw\n\n"
    file = tmp_path / "colors.nrrd"
    file.write_bytes(header + rgba.tobytes())
    assert (layersplat.render(Colors.open(file), shade=False, **VIEW) == picture).all()


def test_directions_of_vectors_are_colors(arrays):
    along_x = np.zeros(arrays[0].shape + (3,), np.float32)
    along_x[..., 0] = -arrays[0]
    along_x[4, 4, 4, 1] = np.nan
    picture = layersplat.render(along_x, colors="direction", shade=False, **VIEW)
    assert picture[..., 0].max() > 40 and picture[..., 1:3].max() <= ROUNDING
    along_z = layersplat.render(along_x[..., [1, 2, 0]], colors="direction", shade=False, **VIEW)
    assert along_z[..., 2].max() > 40 and along_z[..., :2].max() <= ROUNDING
    thin = layersplat.TransferFunction([(0, (1, 1, 1))], [(0, 0), (float(arrays[0].max()), 0.01)])
    faint = layersplat.render(Colors(along_x, direction=True, transfer=thin), shade=False, **VIEW)
    assert 0 < faint[..., 0].max() < picture[..., 0].max()
    with pytest.raises(layersplat.InvalidValue, match="3, x, y and z"):
        Colors(along_x[..., :2], direction=True)
    with pytest.raises(layersplat.InvalidValue, match="norm"):
        Colors(along_x, direction=True, opacity="alpha")


@pytest.mark.parametrize("ids", [(1, 2), (7, 300), (70_000, 4_000_000_000)])
def test_labels_have_the_colours_of_a_table(arrays, ids):
    voxels = np.zeros(arrays[0].shape, np.uint32)
    for number, array in zip(ids, arrays):
        voxels[array > 0.2] = number
    table = {ids[0]: "#ff0000", ids[1]: {"name": "right", "color": (0, 0, 1), "opacity": 0.9}}
    view = {"size": SIZE, "azimuth": 0, "elevation": 0, "quality": "draft"}
    picture = layersplat.render(voxels, labels=table, **view)
    (r, _, b), (r2, _, b2) = mean_color(picture, 0), mean_color(picture, 1)
    assert r > 5 * max(b, 0.1) and b2 > 5 * max(r2, 0.1)
    labels = Labels(voxels, table)
    assert labels.table[ids[1]] == {"name": "right", "color": (0.0, 0.0, 1.0), "opacity": 0.9, "visible": True}
    assert (layersplat.render(labels, **view) == picture).all()
    assert (layersplat.render(Labels(voxels, table, surfaces="smooth"), **view) == picture).all()
    assert (layersplat.render(Labels(voxels, table, surfaces="voxels"), **view) != picture).any()
    with pytest.raises(layersplat.InvalidValue, match="smooth or voxels"):
        Labels(voxels, table, surfaces="round")
    assert (layersplat.render(Labels(voxels, labels.table), **view) == picture).all()
    only = Labels(voxels, table, changes=["right:only"])
    assert [look["visible"] for look in only.table.values()] == [False, True]
    assert layersplat.render(only, **view)[..., 0].max() <= layersplat.render(only, **view)[..., 2].max() / 2
    assert layersplat.render(voxels.astype(np.float64), labels=True, **view).max() > 20


def test_labels_and_colors_are_drawn_beside_a_volume(arrays):
    ids = np.where(arrays[0] > 0.2, 1, np.where(arrays[1] > 0.2, 2, 0)).astype(np.uint8)
    scan = Channel(np.maximum(*arrays), color=(0, 1, 0), factor=0.2)
    view = {"size": SIZE, "azimuth": 0, "elevation": 0, "quality": "draft"}
    # Two opacities: a channel for each.
    labels = Labels(ids, {1: {"color": "#ff0000", "opacity": 0.9}, 2: {"color": "#0000ff", "opacity": 0.5}})
    rgb = np.stack([255 * (arrays[0] > 0.2), 0 * ids, 255 * (arrays[1] > 0.2)], -1).astype(np.uint8)
    for beside in (labels, Colors(rgb)):
        renderer = Renderer([scan, beside])
        camera = renderer.camera(SIZE, azimuth=0, elevation=0)
        picture = renderer.render(camera, SIZE)
        (r, _, b), (r2, _, b2) = mean_color(picture, 0), mean_color(picture, 1)
        assert r > 2 * max(b, 0.1) and b2 > 2 * max(r2, 0.1)
        assert (picture != Renderer([scan]).render(camera, SIZE)).any(), "the test notices what is left out"
        renderer.set_volume([beside, scan])
        assert np.abs(renderer.render(camera, SIZE).astype(int) - picture).max() <= ROUNDING
        assert (layersplat.render([scan, beside], **view) != layersplat.render([scan], **view)).any()


def test_labels_are_opened_with_a_table(tmp_path, arrays):
    np.save(tmp_path / "ids.npy", np.where(arrays[0] > 0.2, 9, 0).astype(np.uint16))
    (tmp_path / "table.json").write_text('{"labels": [{"id": 9, "name": "ball", "color": "#00ff00"}]}')
    labels = Labels.open(tmp_path / "ids.npy", tmp_path / "table.json")
    assert labels.table == {9: {"name": "ball", "color": (0.0, 1.0, 0.0), "opacity": 1.0, "visible": True}}
    raw = Labels.open(tmp_path / "ids.npy", surfaces="voxels")
    assert (layersplat.render(raw, **VIEW) != layersplat.render(labels, **VIEW)).any()
    array = np.load(tmp_path / "ids.npy")
    expected = layersplat.render(array, labels=tmp_path / "table.json", **VIEW)
    assert (layersplat.render(labels, **VIEW) == expected).all() and expected[..., 1].max() > 20


@pytest.fixture
def ids(arrays):
    """Left and right halves of the volume of both balls."""
    return np.where(np.arange(arrays[0].shape[2]) < 10, 7, 300)[None, None].repeat(16, 0).repeat(18, 1).astype(np.uint16)


def test_labels_color_a_volume(tmp_path, arrays, ids):
    data, view = arrays[0] + arrays[1], {"size": SIZE, "azimuth": 0, "elevation": 0, "quality": "draft", "cmap": "grey", "background": "transparent"}
    table = {7: "#ff0000", 300: {"name": "right", "color": (0, 0, 1)}}
    plain = layersplat.render(data, **view)
    picture = layersplat.render(data, label_colors=ids, labels=table, **view)
    (r, g, b), (r2, g2, b2) = mean_color(picture, 0), mean_color(picture, 1)
    assert min(r, b2) > 20 and max(g, b, r2, g2) < 2
    assert (picture[..., 3] == plain[..., 3]).all() and (plain[..., 0] == plain[..., 2]).all(), "the opacity stays"
    # Labels, files, and image objects are the same; without a table, colours depend on the ids.
    labels = Labels(ids, table)
    np.save(tmp_path / "ids.npy", ids)
    (tmp_path / "table.json").write_text('{"labels": [{"id": 7, "color": "#ff0000"}, {"id": 300, "color": "#0000ff"}]}')
    for given in [{"label_colors": labels}, {"label_colors": tmp_path / "ids.npy", "labels": tmp_path / "table.json"}]:
        assert (layersplat.render(data, **given, **view) == picture).all(), given
    assert (layersplat.render(data, label_colors=str(tmp_path / "ids.npy"), labels=table, **view) == picture).all()
    own = layersplat.render(data, label_colors=ids, labels=True, **view)
    assert (own != picture).any() and (own == layersplat.render(data, label_colors=ids, **view)).all()
    # Without a placement of their own, they lie where the volume does.
    assert (layersplat.render(data, 2.5, label_colors=ids, labels=table, **view) == layersplat.render(data, label_colors=ids, labels=table, **view)).all()
    # Hidden labels keep the colours of the volume.
    assert (layersplat.render(data, label_colors=labels.changed(["7,300:hide"]), **view) == plain).all()
    assert mean_color(layersplat.render(data, label_colors=labels.changed(["right:only"]), **view), 0)[1] > 10
    assert [look["visible"] for look in labels.table.values()] == [True, True], "a copy"


def test_renderers_draw_in_the_colours_of_labels(arrays, transfer, ids):
    renderer = Renderer(arrays[0], transfer.stretched(0.0, 1.0))
    camera = renderer.camera(SIZE)
    unlit = layersplat.Settings(shading=False)
    plain = renderer.render(camera, SIZE, unlit)
    renderer.set_label_colors(Labels(ids, {7: "#00ff00", 300: "#00ff00"}))
    green = renderer.render(camera, SIZE, unlit)
    assert green[..., 1].max() > 60 and green[..., 0].max() <= ROUNDING < plain[..., 0].max()
    # Another volume has them, too.
    renderer.set_volume(arrays[1])
    assert (renderer.render(camera, SIZE, unlit) != green).any()
    renderer.set_volume(arrays[0])
    assert (renderer.render(camera, SIZE, unlit) == green).all()
    renderer.set_label_colors(None)
    assert (renderer.render(camera, SIZE, unlit) == plain).all()


def test_wrong_labels_over_a_volume_are_refused(arrays, transfer, ids):
    def refused(kind, match, call, *arguments, **options):
        with pytest.raises(kind, match=match):
            call(*arguments, **options)

    render, view, labels = layersplat.render, {"size": SIZE, "quality": "draft"}, Labels(ids)
    refused(layersplat.InvalidValue, "label_colors: leave it out", render, arrays, label_colors=ids, **view)
    refused(layersplat.InvalidValue, "labels: leave it out", render, arrays[0], label_colors=labels, labels={7: "x"}, **view)
    refused(layersplat.InvalidValue, "whole numbers", render, arrays[0], label_colors=arrays[1], **view)
    refused(layersplat.InvalidValue, "three", render, arrays[0], label_colors=7, **view)
    refused(layersplat.InvalidValue, "colours of labels", render, arrays[0], label_colors=ids, blend="maximum", **view)
    refused(layersplat.FileNotFound, "nothing.nrrd", render, arrays[0], label_colors="nothing.nrrd", **view)
    sitk = pytest.importorskip("SimpleITK")
    image = sitk.GetImageFromArray(ids)
    image.SetOrigin((500.0, 0.0, 0.0))
    refused(layersplat.InvalidValue, "lie outside", render, arrays[0], label_colors=image, **view)
    renderer = Renderer([Channel(arrays[0]), Channel(arrays[1])])
    renderer.set_label_colors(labels)
    refused(layersplat.InvalidValue, "one volume", renderer.render, renderer.camera(SIZE), SIZE)
    refused(layersplat.InvalidType, "Labels", renderer.set_label_colors, ids)
    streaming = Renderer(arrays[0], transfer, device=layersplat.Device(memory=1 << 20))
    refused(layersplat.InvalidValue, "set_label_colors", streaming.set_label_colors, labels)
    shown = layersplat.volshow(arrays[0], label_colors=ids, size=SIZE)
    refused(layersplat.InvalidValue, "cannot be set", setattr, shown, "label_colors", labels)
    shown.close()


def test_wrong_arguments_are_refused(arrays, transfer):
    def refused(match, call, *arguments, **options):
        with pytest.raises(layersplat.InvalidValue, match=match):
            call(*arguments, **options)

    render, channels = layersplat.render, layersplat.channels
    stacked = np.stack(arrays)
    refused("for each of the 2 channels", channels, arrays, cmap=["fire"])
    refused("factor", channels, arrays, factor=[-1.0, 1.0])
    refused("factor", Channel, arrays[0], factor=float("nan"))
    refused("color", Channel, arrays[0], color=(2.0, 0.0, 0.0))
    refused("color", Channel, arrays[0], transfer, color=(1.0, 0.0, 0.0))
    refused("channel_axis", channels, stacked, channel_axis=4)
    refused("three|four", channels, arrays[0], channel_axis=0)
    refused("1 to 8", render, arrays * 5, **VIEW)
    refused("some items", Renderer, [Channel(arrays[0]), arrays[1]])
    refused("transfer", Renderer, [Channel(arrays[0])], transfer)
    refused("direct", render, stacked, colors="rgb")
    refused("give one of", render, stacked, colors="direct", labels=True)
    refused("cmap: leave out", render, stacked, colors="direct", cmap="fire")
    refused("factor: leave out", render, arrays[0], factor=[1.0])
    refused("components: give 3", Colors, stacked)
    refused("axes", Colors, arrays[0])
    refused("type int16", Colors, np.zeros((2, 2, 2, 3), np.int16))
    refused("no alpha", Colors, np.zeros((2, 2, 2, 3), np.uint8), opacity="alpha")
    refused("opacity", Colors, np.zeros((2, 2, 2, 3), np.uint8), opacity="beta")
    refused("whole numbers", Labels, arrays[0])
    refused("whole numbers", Labels, -np.arange(12).reshape(3, 2, 2))
    refused("different ids", Labels, np.arange(1, 70_001).reshape(100, 70, 10))
    refused("0 is the background", Labels, np.ones((2, 2, 2), int), {0: "#ffffff"})
    refused("key 'colour'", Labels, np.ones((2, 2, 2), int), {1: {"colour": "#ffffff"}})
    refused("#rrggbb", Labels, np.ones((2, 2, 2), int), {1: "#ff"})
    refused("no label has the id 5", Labels, np.ones((2, 2, 2), int), changes=["5:hide"])
    with pytest.raises(layersplat.InvalidType, match="table"):
        Labels(np.ones((2, 2, 2), int), 7)
    with pytest.raises(layersplat.InvalidType, match="list of volumes"):
        channels(arrays[0])
