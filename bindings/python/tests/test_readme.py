"""Runs the examples of README.md."""

import pathlib
import re

import matplotlib
import numpy
import pyopencl as cl
import pytest

import layersplat

BLOCKS = re.findall(r"```python\n(.*?)```", (pathlib.Path(__file__).parents[1] / "README.md").read_text(), re.S)
POCL = "Portable Computing Language"


def simulate(queue, voxels):
    """Replaces the kernel of the example: fills voxels with a number."""
    return cl.enqueue_fill_buffer(queue, voxels, numpy.uint8(120), 0, voxels.size)


@pytest.mark.parametrize("block", BLOCKS, ids=["short", "long", "pyopencl"])
def test_examples(block, array, transfer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYOPENCL_CTX", "0")
    platforms = {device["platform"] for device in layersplat.Device.list()}
    if POCL not in platforms:
        block = block.replace('device="pocl"', f"device={platforms.pop()!r}")
    known = {"layersplat": layersplat, "numpy": numpy, "cl": cl, "matplotlib": matplotlib, "simulate": simulate}
    known.update(array=array, image=array, transfer=transfer)
    exec(block, known)
    pictures = [known[name] for name in ("picture", "floats", "host") if isinstance(known.get(name), numpy.ndarray)]
    assert pictures and all(picture.shape[2] == 4 and picture.max() > 0 for picture in pictures)


def test_pocl_is_found_by_its_short_name(array, transfer):
    if POCL not in {device["platform"] for device in layersplat.Device.list()}:
        pytest.skip("there is no PoCL on this machine")
    assert layersplat.Device("pocl").platform == layersplat.Device("PoCL").platform == POCL
    assert layersplat.Renderer(array, transfer, device="pocl").render(layersplat.Camera((0, 0, 9), (0, 0, 0), scale=9), 9).shape == (9, 9, 4)
