"""Cancellation of frames from another thread."""

import concurrent.futures
import threading
import time

import numpy as np
import pyopencl as cl
import pytest

import layersplat
from host import SIZE, Host


class Blocked:
    """A renderer whose queue is blocked until `release`."""

    def __init__(self, array, transfer):
        self.host = Host()
        self.renderer = layersplat.Renderer(array, transfer, queue=self.host.queue)
        self.camera = self.renderer.camera(SIZE)
        self.expected = self.renderer.render(self.camera, SIZE)
        self.renderer.depths(self.camera, SIZE)
        self.gate = cl.UserEvent(self.host.context)
        cl.enqueue_barrier(self.host.queue, wait_for=[self.gate])

    def release(self):
        self.gate.set_status(cl.command_execution_status.COMPLETE)


def outcome(call):
    try:
        return call()
    except layersplat.Cancelled as error:
        return error


def test_another_thread_cancels_the_frame_in_progress_and_those_that_wait(array, transfer):
    blocked = Blocked(array, transfer)
    renderer, camera = blocked.renderer, blocked.camera
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        calls = [renderer.render, renderer.render_float, renderer.depths, renderer.prepare]
        found = [pool.submit(outcome, lambda call=call: call(camera, SIZE)) for call in calls]
        time.sleep(0.5)
        renderer.cancel()
        # Started afterwards, so not cancelled.
        later = pool.submit(outcome, lambda: renderer.render(camera, SIZE))
        blocked.release()
        found = [future.result(60) for future in found]
        # The current frame may have reached its last kernel.
        cancelled = [isinstance(result, layersplat.Cancelled) for result in found]
        assert sum(cancelled) >= 3, found
        assert np.array_equal(later.result(60), blocked.expected)
    assert np.array_equal(renderer.render(camera, SIZE), blocked.expected)


def test_a_frame_on_the_main_thread_ends(array, transfer):
    """Many frames: the cancellation hits one of them."""
    renderer = layersplat.Renderer(array, transfer)
    camera = renderer.camera(SIZE)
    expected = renderer.render(camera, SIZE)
    stop = threading.Event()

    def cancel():
        while not stop.wait(0.01):
            renderer.cancel()

    thread = threading.Thread(target=cancel)
    thread.start()
    try:
        with pytest.raises(concurrent.futures.CancelledError) as caught:
            for _ in range(10_000):
                renderer.render(camera, SIZE)
    finally:
        stop.set()
        thread.join()
    assert isinstance(caught.value, layersplat.Cancelled) and "cancelled" in str(caught.value)
    assert np.array_equal(renderer.render(camera, SIZE), expected)


def test_nothing_to_cancel(array, transfer):
    renderer = layersplat.Renderer(array, transfer)
    renderer.cancel()
    assert renderer.render(renderer.camera(9), 9).shape == (9, 9, 4), "only calls in progress are cancelled"
