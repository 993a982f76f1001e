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
        buffer = host.buffer(picture.shape, np.uint8)
        event = renderer.enqueue(camera, SIZE, buffer, settings, background="white")
        found = host.read(buffer, np.uint8, event)
        # The range of voxels in place is not checked, so sums are computed in another order.
        assert np.abs(found.astype(int) - picture).max() <= 1
        assert np.array_equal(found, renderer.render(camera, SIZE, settings, background="white"))
        floats = host.buffer(picture.shape, np.float32)
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
    assert (rows[:, 4 * SIZE[0] :] == 7).all() and (found[:4] == 7).all(), "bytes around the picture are unchanged"


def test_images_take_pictures(array, transfer, host):
    renderer = layersplat.Renderer(array, transfer, queue=host.queue)
    camera = renderer.camera(SIZE, **PLACE)
    bytes_of_rgba = cl.ImageFormat(cl.channel_order.RGBA, cl.channel_type.UNORM_INT8)
    image = cl.create_image(host.context, cl.mem_flags.READ_WRITE, bytes_of_rgba, SIZE)
    event = renderer.enqueue(camera, SIZE, image)
    found = np.zeros((SIZE[1], SIZE[0], 4), np.uint8)
    cl.enqueue_copy(host.queue, found, image, origin=(0, 0), region=SIZE, wait_for=[event.to_pyopencl()])
    assert np.array_equal(found, renderer.render(camera, SIZE))


def test_arguments_select_the_device(array, transfer, host):
    camera = layersplat.Renderer(array, transfer).camera(SIZE)
    expected = layersplat.Renderer(array, transfer).render(camera, SIZE)
    device = host.context.devices[0]
    whole = {"context": host.context, "device": device, "queue": host.queue}
    for handles in [whole, {"context": host.context}, {"queue": host.queue.int_ptr}, {"context": host.context.int_ptr, "device": device}]:
        assert np.array_equal(layersplat.Renderer(array, transfer, **handles).render(camera, SIZE), expected), handles
        found = layersplat.Device(**handles)
        assert found.context == host.context.int_ptr and found.id == device.int_ptr
        assert (found.queue == host.queue.int_ptr) == ("queue" in handles)
    other = Host()
    for wrong in [{"context": other.context, "queue": host.queue}, {"device": device}]:
        with pytest.raises(layersplat.InvalidValue):
            layersplat.Renderer(array, transfer, **wrong)


def test_arrays_of_pyopencl_are_volumes(array, transfer, host):
    spread = np.full((20, 24, 40), 255, np.uint8)
    spread[:, :, 5:33] = array
    voxels = pyopencl.array.to_device(host.queue, spread)[:, :, 5:33]
    host.queue.finish()
    camera = layersplat.Renderer(array, transfer).camera(SIZE, **PLACE)
    found = layersplat.Renderer(voxels, transfer).render(camera, SIZE).astype(int)
    assert np.abs(found - layersplat.Renderer(array, transfer).render(camera, SIZE)).max() <= 1
    with pytest.raises(layersplat.InvalidValue, match="transfer"):
        layersplat.Renderer(voxels)


@pytest.mark.parametrize("source", ["array", "volume"])
def test_a_memory_pool_does_not_reuse_voxels_in_use(array, transfer, host, source):
    """A pool reuses a buffer when its Python object is gone, even if the cl_mem is retained."""
    pool = cl.tools.MemoryPool(cl.tools.ImmediateAllocator(host.queue))
    voxels = pyopencl.array.to_device(host.queue, array, allocator=pool)
    handle = voxels.base_data.int_ptr
    if source == "array":
        renderer = layersplat.Renderer(voxels, transfer)
    else:
        volume = layersplat.DeviceVolume(host.device(), voxels.base_data, array.shape, array.dtype)
        renderer = layersplat.Renderer(volume, transfer)
        del volume
    camera = renderer.camera(SIZE, **PLACE)
    expected = renderer.render(camera, SIZE)
    del voxels
    gc.collect()
    other = pyopencl.array.to_device(host.queue, 255 - array, allocator=pool)
    host.queue.finish()
    assert other.base_data.int_ptr != handle
    renderer.volume_changed()
    assert np.array_equal(renderer.render(camera, SIZE), expected)
    del renderer, other
    gc.collect()
    again = [pyopencl.array.to_device(host.queue, array, allocator=pool) for _ in range(2)]
    assert handle in [one.base_data.int_ptr for one in again], "the buffer returns to the pool with the renderer"


def test_frames_are_enqueued_and_not_waited_for(array, transfer, host):
    renderer = layersplat.Renderer(array, transfer, queue=host.queue)
    camera = renderer.camera(SIZE, **PLACE)
    renderer.prepare(camera, SIZE)
    expected = renderer.render(camera, SIZE)
    buffer = host.filled(np.full(expected.shape, 9, np.uint8))
    gate = cl.UserEvent(host.context)
    began = time.perf_counter()
    first = renderer.enqueue(camera, SIZE, buffer, wait_for=[gate])
    second = renderer.enqueue(camera, SIZE, buffer, wait_for=[first])
    assert time.perf_counter() - began < 5 and not first.is_complete and not second.is_complete
    # Another queue is not blocked.
    before = np.zeros_like(expected)
    cl.enqueue_copy(host.another_queue(), before, buffer)
    assert (before == 9).all(), "nothing is written before the wait list completes"
    gate.set_status(cl.command_execution_status.COMPLETE)
    second.wait()
    assert first.is_complete and second.is_complete
    assert np.array_equal(host.read(buffer, np.uint8), expected)


def test_a_failed_event_fails_only_its_frame(array, transfer, host):
    renderer = layersplat.Renderer(array, transfer, queue=host.queue)
    camera = renderer.camera(SIZE)
    renderer.prepare(camera, SIZE)
    buffer, gate = host.buffer((60, 72, 4), np.uint8), cl.UserEvent(host.context)
    event = renderer.enqueue(camera, SIZE, buffer, wait_for=[gate])
    assert not event.is_complete
    gate.set_status(CL_OUT_OF_RESOURCES)
    with pytest.raises(layersplat.DeviceError, match="clWaitForEvents"):
        event.wait()
    # A loop that waits for completion must end.
    with pytest.raises(layersplat.DeviceError, match="enqueued command failed.*-[0-9]+"):
        event.is_complete
    assert np.array_equal(host.read(buffer, np.uint8, renderer.enqueue(camera, SIZE, buffer)), renderer.render(camera, SIZE))


def test_a_kernel_changes_the_voxels(array, transfer, host):
    """Voxels are written and rendered on the device, without a copy to the host."""
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


@pytest.mark.parametrize("source", ["array", "volume"])
def test_voxels_on_the_device_do_not_replace_a_volume(array, transfer, host, source):
    other = 255 - array
    if source == "array":
        voxels = pyopencl.array.to_device(host.queue, other)
    else:
        voxels = layersplat.DeviceVolume(host.device(), host.filled(other), other.shape, other.dtype)
    renderer = layersplat.Renderer(array, transfer, queue=host.queue)
    camera = renderer.camera(SIZE, **PLACE)
    before = renderer.render(camera, SIZE)
    with pytest.raises(layersplat.InvalidType, match="voxels on a device: make a new Renderer of it, or give an array on the host") as caught:
        renderer.set_volume(voxels)
    assert caught.value.fields == ("volume",)
    assert np.array_equal(renderer.render(camera, SIZE), before)


def test_an_array_replaces_voxels_on_the_device(array, transfer, host):
    """The new voxels have a buffer of their own: the caller's buffer keeps its contents."""
    buffer = host.filled(array)
    renderer = layersplat.Renderer(layersplat.DeviceVolume(host.device(), buffer, array.shape, array.dtype), transfer)
    camera = renderer.camera(SIZE, **PLACE)
    renderer.set_volume(255 - array)
    assert np.array_equal(renderer.render(camera, SIZE), layersplat.Renderer(255 - array, transfer).render(camera, SIZE))
    kept = np.zeros_like(array)
    cl.enqueue_copy(host.queue, kept, buffer)
    assert np.array_equal(kept, array)


def test_caller_objects_are_retained_and_released(array, transfer):
    host = Host()
    voxels, buffer = host.filled(array), host.buffer((60, 72, 4), np.uint8)

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
        # PoCL's threads release a command shortly after they report it as complete.
        for _ in range(500):
            host.queue.finish()
            if references() == before:
                break
            time.sleep(0.01)
        assert during[0] > before[0] and during[1] > before[1]
        assert references() == before


def test_unsuitable_memory_is_rejected(array, transfer, host):
    device, renderer = host.device(), layersplat.Renderer(array, transfer, queue=host.queue)
    camera = renderer.camera(SIZE)
    small, foreign = host.buffer((10,), np.uint8), Host().buffer((60, 72, 4), np.uint8)
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
        renderer.enqueue(camera, SIZE, host.buffer((60, 72, 4), np.uint8), layersplat.Settings(algorithm="axis-sheets"))
    with pytest.raises(TypeError, match="int_ptr"):
        renderer.enqueue(camera, SIZE, np.zeros((60, 72, 4), np.uint8))
    with pytest.raises(layersplat.InvalidValue, match="null"):
        renderer.enqueue(camera, SIZE, 0)
