"""An application with its own OpenCL context and queue, made with pyopencl, that embeds layersplat."""

import numpy as np
import pyopencl as cl

import layersplat

SIZE = (72, 60)
OUT_OF_ORDER = cl.command_queue_properties.OUT_OF_ORDER_EXEC_MODE_ENABLE


class Host:
    """A context and a queue on the default device of layersplat."""

    def __init__(self, properties=0):
        platform = layersplat.Device.list()[0]["platform"]
        devices = next(p for p in cl.get_platforms() if p.name == platform).get_devices()
        self.context = cl.Context(devices[:1])
        self.queue = self.another_queue(properties)

    def another_queue(self, properties=0):
        return cl.CommandQueue(self.context, properties=properties)

    def device(self):
        return layersplat.Device(queue=self.queue)

    def filled(self, array):
        flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
        return cl.Buffer(self.context, flags, hostbuf=np.ascontiguousarray(array))

    def buffer(self, shape, dtype):
        return cl.Buffer(self.context, cl.mem_flags.READ_WRITE, int(np.prod(shape)) * np.dtype(dtype).itemsize)

    def read(self, buffer, dtype, event=None, size=SIZE):
        """Reads a picture from a buffer after an event."""
        values = np.zeros((size[1], size[0], 4), dtype)
        cl.enqueue_copy(self.queue, values, buffer, wait_for=None if event is None else [event.to_pyopencl()])
        return values
