"""What README.md shows runs as it stands there."""

import pathlib
import re

import matplotlib
import numpy
import pyopencl as cl
import pytest

import layersplat

BLOCKS = re.findall(r"```python\n(.*?)```", (pathlib.Path(__file__).parents[1] / "README.md").read_text(), re.S)


def simulate(queue, voxels):
    """Stands for a kernel: fills voxels with a number."""
    return cl.enqueue_fill_buffer(queue, voxels, numpy.uint8(120), 0, voxels.size)


@pytest.mark.parametrize("block", BLOCKS, ids=["short", "long", "pyopencl"])
def test_examples(block, array, transfer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYOPENCL_CTX", "0")
    # Of the device that a machine has, whatever it is called.
    name = layersplat.Device().platform
    known = {"layersplat": layersplat, "numpy": numpy, "cl": cl, "matplotlib": matplotlib, "simulate": simulate}
    known.update(array=array, image=array, transfer=transfer)
    exec(block.replace('device="pocl"', f"device={name!r}"), known)
    pictures = [known[name] for name in ("picture", "floats", "host") if isinstance(known.get(name), numpy.ndarray)]
    assert pictures and all(picture.shape[2] == 4 and picture.max() > 0 for picture in pictures)
