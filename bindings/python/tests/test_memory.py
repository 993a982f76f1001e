"""Memory budgets: volumes that do not fit are streamed; the picture is identical."""

import numpy as np
import pytest

import layersplat
from host import SIZE, Host

BUDGET = 2_000_000
"""Bytes: half of the voxels, and more than the tables of a frame, about a megabyte."""


@pytest.fixture(scope="module")
def large():
    """(z, y, x), uint8: twice the budget, asymmetric."""
    z, y, x = np.ogrid[0:1:160j, 0:1:161j, 0:1:162j]
    return (120 + 60 * np.sin(9 * x + 2 * y) + 50 * np.cos(7 * y * z + 5 * z)).astype(np.uint8)


@pytest.fixture(scope="module")
def faint():
    """Transparent enough that every part of the volume is visible."""
    return layersplat.TransferFunction([(0, (1, 0, 0)), (255, (0, 1, 1))], [(60, 0.0), (240, 0.02)])


@pytest.fixture(scope="module")
def whole(large, faint):
    return layersplat.Renderer(large, faint)


def limited(memory=BUDGET):
    return layersplat.Device(memory=memory)


def test_a_volume_beyond_the_budget_has_the_same_picture(large, faint, whole):
    device = limited()
    assert device.memory == BUDGET and layersplat.Device().memory is None
    renderer = layersplat.Renderer(large, faint, device=device)
    for azimuth in (10, 80):
        camera = renderer.camera(SIZE, azimuth=azimuth, elevation=8)
        plan = renderer.stream_plan(camera, SIZE)
        assert plan["volume_bytes"] == large.size > 2 * BUDGET
        assert [lattice["axis"] for lattice in plan["lattices"]] == ["z" if azimuth < 45 else "x"]
        assert plan["lattices"][0]["parts"] > 1 and plan["lattices"][0]["held_layers"] < 160
        assert plan["device_bytes"] <= plan["available_bytes"] <= BUDGET
        assert whole.stream_plan(camera, SIZE) is None
        # As in the library's tests/rendering/streamed.rs, no difference is allowed.
        expected = whole.render_float(camera, SIZE)
        assert 0.05 < expected[..., 3].max() < 0.99
        assert np.array_equal(renderer.render_float(camera, SIZE), expected)
        assert np.array_equal(renderer.render(camera, SIZE), whole.render(camera, SIZE))
        assert device.allocated_bytes <= BUDGET


def test_a_streaming_renderer_is_used_as_any_other(large, faint, whole):
    renderer = layersplat.Renderer(large, faint, device=limited())
    camera = renderer.camera(SIZE)
    renderer.prepare(camera, SIZE)
    assert renderer.transfer == faint
    renderer.transfer = other = faint.faded(0.5)
    assert renderer.transfer == other
    assert renderer.render_float(camera, SIZE)[..., 3].max() < whole.render_float(camera, SIZE)[..., 3].max()
    renderer.time_limit = 0.0
    with pytest.raises(layersplat.TimedOut):
        renderer.render(camera, SIZE)
    shown = layersplat.volshow(large, size=SIZE, cmap=faint, device=limited())
    assert np.array_equal(shown.render(), layersplat.render(large, size=SIZE, cmap=faint))


def test_a_volume_that_fits_stays_on_the_device(array, transfer):
    renderer = layersplat.Renderer(array, transfer, device=limited(50_000_000))
    camera = renderer.camera(SIZE)
    assert np.array_equal(renderer.render(camera, SIZE), layersplat.Renderer(array, transfer).render(camera, SIZE))
    assert renderer.stream_plan(camera, SIZE)["lattices"][0]["parts"] == 1


@pytest.mark.parametrize("is_streamed", [False, True])
def test_another_volume_replaces_the_first(large, faint, is_streamed):
    renderer = layersplat.Renderer(large, faint, device=limited() if is_streamed else None)
    camera = renderer.camera(SIZE)
    before = renderer.render(camera, SIZE)
    other = np.flip(np.asarray(large), axis=0)[::2].copy()
    renderer.set_volume(other)
    expected = layersplat.Renderer(other, faint).render(camera, SIZE)
    assert np.array_equal(renderer.render(camera, SIZE), expected) and not np.array_equal(before, expected)
    with pytest.raises(layersplat.Error):
        renderer.set_volume("no such volume")


def test_calls_that_need_the_whole_volume_are_rejected(large, faint):
    renderer = layersplat.Renderer(large, faint, device=limited())
    camera = renderer.camera(SIZE)
    for call in [
        lambda: renderer.depths(camera, SIZE),
        lambda: renderer.render(camera, SIZE, layersplat.Settings(algorithm="raycast")),
        lambda: renderer.stream_plan(camera, SIZE, layersplat.Settings(algorithm="slicing")),
    ]:
        with pytest.raises(layersplat.OutOfMemory, match="whole volume.*set at least") as caught:
            call()
        assert caught.value.fields == ("memory",)
    host = Host()
    on_queue = layersplat.Device(queue=host.queue, memory=BUDGET)
    assert on_queue.queue == host.queue.int_ptr
    renderer = layersplat.Renderer(large, faint, device=on_queue)
    buffer = host.buffer((SIZE[1], SIZE[0], 4), np.uint8)
    for call, name in [(lambda: renderer.enqueue(camera, SIZE, buffer), "enqueue"), (renderer.volume_changed, "volume_changed")]:
        with pytest.raises(layersplat.InvalidValue, match=f"Renderer.{name} needs.*render into host memory instead") as caught:
            call()
        assert caught.value.fields == ("memory",)
    assert renderer.render(camera, SIZE).max() > 20, "the renderer stays usable"


def test_voxels_on_the_device_take_none_of_the_budget(array, transfer):
    host = Host()
    device = layersplat.Device(queue=host.queue, memory=50_000_000)
    volume = layersplat.DeviceVolume(device, host.filled(array), array.shape, np.uint8)
    renderer, picture = layersplat.Renderer(volume, transfer), host.buffer((SIZE[1], SIZE[0], 4), np.uint8)
    drawn = renderer.enqueue(renderer.camera(SIZE), SIZE, picture)
    assert host.read(picture, np.uint8, drawn).max() > 20


def test_a_budget_too_small_for_one_layer(large, faint):
    renderer = layersplat.Renderer(large, faint, device=limited(1000))
    camera = renderer.camera(SIZE)
    for call in [renderer.render, renderer.render_float, renderer.stream_plan]:
        with pytest.raises(MemoryError, match="the memory budget is 1000: set at least") as caught:
            call(camera, SIZE)
        assert isinstance(caught.value, layersplat.OutOfMemory)


@pytest.mark.parametrize("memory, error", [("2G", layersplat.InvalidType), (-1, layersplat.InvalidValue)])
def test_invalid_budgets(memory, error):
    with pytest.raises(error, match="memory is .*expected a whole number") as caught:
        limited(memory)
    assert caught.value.fields == ("memory",)
