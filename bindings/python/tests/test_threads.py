"""Long calls release the GIL, and threads may share objects."""

import faulthandler
import threading

import numpy as np
import pyopencl as cl
import pytest

import layersplat
from host import SIZE, Host


@pytest.fixture
def deadline():
    """Ends a process that hangs, with a traceback."""
    faulthandler.dump_traceback_later(90, exit=True)
    yield
    faulthandler.cancel_dump_traceback_later()


class Held:
    """Blocks a queue until another Python thread has run."""

    def __init__(self, host):
        self.gate, self.progress = cl.UserEvent(host.context), 0
        cl.enqueue_marker(host.queue, wait_for=[self.gate])
        cl.enqueue_barrier(host.queue, wait_for=[self.gate])
        self.thread = threading.Thread(target=self._run)
        self.inside = threading.Event()

    def _run(self):
        self.inside.wait()
        for _ in range(200_000):
            self.progress += 1
        self.gate.set_status(cl.command_execution_status.COMPLETE)

    def __enter__(self):
        self.thread.start()
        self.inside.set()
        return self

    def __exit__(self, *_):
        self.thread.join()


@pytest.mark.parametrize("call", ["render", "render_float", "prepare", "wait", "describe"])
def test_another_thread_runs_meanwhile(array, transfer, deadline, call):
    """The queue waits for another Python thread: if the call held the GIL, it would never return."""
    host = Host()
    renderer = layersplat.Renderer(array, transfer, queue=host.queue)
    camera = renderer.camera(SIZE)
    buffer = host.buffer((60, 72, 4), np.uint8)
    calls = {
        "render": lambda: renderer.render(camera, SIZE),
        "render_float": lambda: renderer.render_float(camera, SIZE),
        "prepare": lambda: renderer.prepare(camera, SIZE),
        "wait": lambda: renderer.enqueue(camera, SIZE, buffer).wait(),
        "describe": lambda: layersplat.DeviceVolume(host.device(), voxels, array.shape, np.uint8),
    }
    voxels = host.filled(array)
    renderer.prepare(camera, SIZE)
    with Held(host) as other:
        calls[call]()
        assert other.progress == 200_000


def test_threads_share_a_renderer(array, transfer, deadline):
    renderer = layersplat.Renderer(array, transfer)
    cameras = [renderer.camera(SIZE, azimuth=azimuth) for azimuth in range(0, 80, 10)]
    expected = [renderer.render(camera, SIZE) for camera in cameras]
    found, threads = {}, []
    for n, camera in enumerate(cameras):
        threads.append(threading.Thread(target=lambda n=n, camera=camera: found.update({n: renderer.render(camera, SIZE)})))
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(found[n], picture) for n, picture in enumerate(expected))
