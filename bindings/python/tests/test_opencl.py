"""pyopencl's contexts, queues, buffers and events: voxels and pictures stay on the device."""

import gc
import time

import numpy as np
import pyopencl as cl
import pyopencl.array
import pyopencl.tools
import pytest

import layersplat
from host import OUT_OF_ORDER, SIZE, Host

PLACE = {"azimuth": 35.0, "elevation": -25.0}
CL_OUT_OF_RESOURCES = -5


@pytest.fixture(params=[0, OUT_OF_ORDER], ids=["in order", "out of order"])
def host(request):
    return Host(request.param)


def test_a_buffer_in_and_a_buffer_out_are_the_pictures_of_the_host(array, transfer, host):
    expected = layersplat.Renderer(array, transfer)
    camera = expected.camera(SIZE, **PLACE)
    voxels = layersplat.DeviceVolume(host.device(), host.filled(array), array.shape, array.dtype)
    assert voxels.range == (array.min(), array.max()) and voxels.shape == array.shape
    renderer = layersplat.Renderer(voxels, transfer)
    for settings in [None, layersplat.Settings("high"), layersplat.Settings(blend="maximum")]:
        picture = expected.render(camera, SIZE, settings, background="white")
        assert picture.min() < 200
        buffer = host.room(picture.shape, np.uint8)
        event = renderer.enqueue(camera, SIZE, buffer, settings, background="white")
        found = host.read(buffer, np.uint8, event)
        # The range of voxels in place is a promise only, so sums are taken in another order.
        assert np.abs(found.astype(int) - picture).max() <= 1
        assert np.array_equal(found, renderer.render(camera, SIZE, settings, background="white"))
        floats = host.room(picture.shape, np.float32)
        event = renderer.enqueue(camera, SIZE, floats.int_ptr, settings, format="float")
        found = host.read(floats, np.float32, event)
        assert np.array_equal(found, renderer.render_float(camera, SIZE, settings))
        assert np.abs(found - expected.render_float(camera, SIZE, settings)).max() < 2e-6


def test_uploaded_volumes_go_into_buffers_to_the_bit(array, transfer, host):
    renderer = layersplat.Renderer(array, transfer, queue=host.queue)
    default = layersplat.Renderer(array, transfer)
    camera = default.camera(SIZE, **PLACE)
    expected = default.render(camera, SIZE)
    assert np.array_equal(renderer.render(camera, SIZE), expected)
    padded = np.full((SIZE[1], 4 * SIZE[0] + 12), 7, np.uint8)
    buffer = host.filled(np.concatenate([[7] * 4, padded.ravel()]).astype(np.uint8))
    event = renderer.enqueue(camera, SIZE, buffer, first=4, row_pitch=padded.shape[1])
    found = np.zeros(4 + padded.size, np.uint8)
    cl.enqueue_copy(host.queue, found, buffer, wait_for=[event.to_pyopencl()])
    rows = found[4:].reshape(padded.shape)
    assert np.array_equal(rows[:, : 4 * SIZE[0]].reshape(expected.shape), expected)
    assert (rows[:, 4 * SIZE[0] :] == 7).all() and (found[:4] == 7).all(), "what lies around the picture stays"


def test_images_take_pictures(array, transfer, host):
    renderer = layersplat.Renderer(array, transfer, queue=host.queue)
    camera = renderer.camera(SIZE, **PLACE)
    bytes_of_rgba = cl.ImageFormat(cl.channel_order.RGBA, cl.channel_type.UNORM_INT8)
    image = cl.create_image(host.context, cl.mem_flags.READ_WRITE, bytes_of_rgba, SIZE)
    event = renderer.enqueue(camera, SIZE, image)
    found = np.zeros((SIZE[1], SIZE[0], 4), np.uint8)
    cl.enqueue_copy(host.queue, found, image, origin=(0, 0), region=SIZE, wait_for=[event.to_pyopencl()])
    assert np.array_equal(found, renderer.render(camera, SIZE))


def test_what_is_given_says_which_device(array, transfer, host):
    camera = layersplat.Renderer(array, transfer).camera(SIZE)
    expected = layersplat.Renderer(array, transfer).render(camera, SIZE)
    device = host.context.devices[0]
    whole = {"context": host.context, "device": device, "queue": host.queue}
    for given in [whole, {"context": host.context}, {"queue": host.queue.int_ptr}, {"context": host.context.int_ptr, "device": device}]:
        assert np.array_equal(layersplat.Renderer(array, transfer, **given).render(camera, SIZE), expected), given
        found = layersplat.Device(**given)
        assert found.context == host.context.int_ptr and found.id == device.int_ptr
        assert (found.queue == host.queue.int_ptr) == ("queue" in given)
    other = Host()
    for wrong in [{"context": other.context, "queue": host.queue}, {"device": device}]:
        with pytest.raises(layersplat.InvalidValue):
            layersplat.Renderer(array, transfer, **wrong)


def test_arrays_of_pyopencl_are_volumes(array, transfer, host):
    spread = np.full((20, 24, 40), 255, np.uint8)
    spread[:, :, 5:33] = array
    there = pyopencl.array.to_device(host.queue, spread)[:, :, 5:33]
    host.queue.finish()
    camera = layersplat.Renderer(array, transfer).camera(SIZE, **PLACE)
    found = layersplat.Renderer(there, transfer).render(camera, SIZE).astype(int)
    assert np.abs(found - layersplat.Renderer(array, transfer).render(camera, SIZE)).max() <= 1
    with pytest.raises(layersplat.InvalidValue, match="transfer"):
        layersplat.Renderer(there)


@pytest.mark.parametrize("given", ["array", "volume"])
def test_a_memory_pool_cannot_give_voxels_to_others(array, transfer, host, given):
    """A pool takes a buffer back when its Python object is gone, whoever has retained the cl_mem."""
    pool = cl.tools.MemoryPool(cl.tools.ImmediateAllocator(host.queue))
    there = pyopencl.array.to_device(host.queue, array, allocator=pool)
    handle = there.base_data.int_ptr
    if given == "array":
        renderer = layersplat.Renderer(there, transfer)
    else:
        volume = layersplat.DeviceVolume(host.device(), there.base_data, array.shape, array.dtype)
        renderer = layersplat.Renderer(volume, transfer)
        del volume
    camera = renderer.camera(SIZE, **PLACE)
    expected = renderer.render(camera, SIZE)
    del there
    gc.collect()
    other = pyopencl.array.to_device(host.queue, 255 - array, allocator=pool)
    host.queue.finish()
    assert other.base_data.int_ptr != handle
    renderer.volume_changed()
    assert np.array_equal(renderer.render(camera, SIZE), expected)
    del renderer, other
    gc.collect()
    again = [pyopencl.array.to_device(host.queue, array, allocator=pool) for _ in range(2)]
    assert handle in [one.base_data.int_ptr for one in again], "and it goes back to the pool with the renderer"


def test_frames_are_enqueued_and_not_waited_for(array, transfer, host):
    renderer = layersplat.Renderer(array, transfer, queue=host.queue)
    camera = renderer.camera(SIZE, **PLACE)
    renderer.prepare(camera, SIZE)
    expected = renderer.render(camera, SIZE)
    buffer = host.filled(np.full(expected.shape, 9, np.uint8))
    promise = cl.UserEvent(host.context)
    began = time.perf_counter()
    first = renderer.enqueue(camera, SIZE, buffer, wait_for=[promise])
    second = renderer.enqueue(camera, SIZE, buffer, wait_for=[first])
    assert time.perf_counter() - began < 5 and not first.is_complete and not second.is_complete
    # Another queue is not held up.
    before = np.zeros_like(expected)
    cl.enqueue_copy(host.another_queue(), before, buffer)
    assert (before == 9).all(), "the picture is not begun before what it waits for is over"
    promise.set_status(cl.command_execution_status.COMPLETE)
    second.wait()
    assert first.is_complete and second.is_complete
    assert np.array_equal(host.read(buffer, np.uint8), expected)


def test_a_failed_promise_fails_the_frame_alone(array, transfer, host):
    renderer = layersplat.Renderer(array, transfer, queue=host.queue)
    camera = renderer.camera(SIZE)
    renderer.prepare(camera, SIZE)
    buffer, promise = host.room((60, 72, 4), np.uint8), cl.UserEvent(host.context)
    event = renderer.enqueue(camera, SIZE, buffer, wait_for=[promise])
    assert not event.is_complete
    promise.set_status(CL_OUT_OF_RESOURCES)
    with pytest.raises(layersplat.DeviceError, match="clWaitForEvents"):
        event.wait()
    # A loop that waits for completion must end.
    with pytest.raises(layersplat.DeviceError, match="enqueued command failed.*-[0-9]+"):
        event.is_complete
    assert np.array_equal(host.read(buffer, np.uint8, renderer.enqueue(camera, SIZE, buffer)), renderer.render(camera, SIZE))


def test_a_kernel_changes_the_voxels(array, transfer, host):
    """Voxels are written on the device, and seen, without coming to the host."""
    buffer = host.filled(array)
    volume = layersplat.DeviceVolume(host.device(), buffer, array.shape, "uint8", range=(0, 255))
    renderer = layersplat.Renderer(volume, transfer)
    camera = renderer.camera(SIZE, **PLACE)
    before = renderer.render(camera, SIZE)
    source = "kernel void halve(global uchar *voxels) { voxels[get_global_id(0)] = 255 - voxels[get_global_id(0)] / 2; }"
    changed = cl.Program(host.context, source).build().halve(host.queue, (array.size,), None, buffer)
    renderer.volume_changed(wait_for=[changed])
    after = renderer.render(camera, SIZE)
    other = layersplat.DeviceVolume(host.device(), host.filled(255 - array // 2), array.shape, "uint8", range=(0, 255))
    assert not np.array_equal(before, after)
    assert np.array_equal(after, layersplat.Renderer(other, transfer).render(camera, SIZE))


def test_what_is_handed_over_is_retained_and_released(array, transfer):
    host = Host()
    voxels, buffer = host.filled(array), host.room((60, 72, 4), np.uint8)

    def references():
        info = cl.mem_info.REFERENCE_COUNT
        memory = [voxels.get_info(info), buffer.get_info(info)]
        return [host.context.get_info(cl.context_info.REFERENCE_COUNT), *memory]

    def used():
        volume = layersplat.DeviceVolume(host.device(), voxels, array.shape, np.uint8)
        renderer = layersplat.Renderer(volume, transfer)
        during = references()
        renderer.enqueue(renderer.camera(SIZE), SIZE, buffer).wait()
        return during

    before = references()
    for _ in range(3):
        during = used()
        gc.collect()
        host.queue.finish()
        assert during[0] > before[0] and during[1] > before[1]
        assert references() == before


def test_memory_that_does_not_fit_is_refused(array, transfer, host):
    device, renderer = host.device(), layersplat.Renderer(array, transfer, queue=host.queue)
    camera = renderer.camera(SIZE)
    small, foreign = host.room((10,), np.uint8), Host().room((60, 72, 4), np.uint8)
    for wrong, words in [(small, "10 bytes"), (foreign, "another context")]:
        with pytest.raises(layersplat.InvalidValue, match=words):
            renderer.enqueue(camera, SIZE, wrong)
        with pytest.raises(layersplat.InvalidValue, match=words):
            layersplat.DeviceVolume(device, wrong, array.shape, np.uint8)
    with pytest.raises(layersplat.InvalidValue, match="float64"):
        layersplat.DeviceVolume(device, small, array.shape, np.float64)
    with pytest.raises(layersplat.InvalidValue, match="own byte order"):
        layersplat.DeviceVolume(device, small, array.shape, ">i2")
    with pytest.raises(layersplat.InvalidValue, match="use `render`"):
        renderer.enqueue(camera, SIZE, host.room((60, 72, 4), np.uint8), layersplat.Settings(algorithm="axis-sheets"))
    with pytest.raises(TypeError, match="int_ptr"):
        renderer.enqueue(camera, SIZE, np.zeros((60, 72, 4), np.uint8))
    with pytest.raises(layersplat.InvalidValue, match="null"):
        renderer.enqueue(camera, SIZE, 0)
