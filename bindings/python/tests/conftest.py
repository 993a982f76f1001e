"""Shared fixtures: an asymmetric volume, and the command for comparison."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import layersplat

SIZE = (72, 60)


@pytest.fixture(scope="session")
def array():
    """(z, y, x) = (20, 24, 28), uint8: smooth and asymmetric."""
    z, y, x = np.mgrid[0:20, 0:24, 0:28].astype(float)
    one = np.exp(-((x - 18) ** 2 + (y - 13) ** 2 + (z - 8) ** 2) / 40)
    two = np.exp(-((x - 8) ** 2 / 3 + (y - 7) ** 2 + (z - 14) ** 2) / 15)
    values = np.round(230 * one + 120 * two + (x * 7 + y * 3 + z * 5) % 9).clip(0, 255).astype(np.uint8)
    values.flags.writeable = False
    return values


@pytest.fixture(scope="session")
def transfer(array):
    return layersplat.TransferFunction.builtin("fire", (0.0, 255.0))


@pytest.fixture(scope="session")
def command():
    """Runs the command `layersplat`: LAYERSPLAT_COMMAND, built by ./test."""
    path = os.environ.get("LAYERSPLAT_COMMAND")
    if not path:
        pytest.skip("LAYERSPLAT_COMMAND does not name a command")

    def run(*arguments):
        subprocess.run([path, *map(str, arguments)], check=True, capture_output=True, timeout=300)

    return run


@pytest.fixture(scope="session")
def picture():
    """Renders the picture of a volume with fixed transfer function, size and background, so that pictures are comparable."""

    def render(data, spacing=None, **options):
        options = {"cmap": "fire", "clim": (0, 255), "size": SIZE, "background": "transparent", **options}
        found = layersplat.render(data, spacing, **options)
        assert found[..., :3].max() > 20, "something is visible"
        return found

    return render


@pytest.fixture(scope="session")
def shared():
    """The path of a real volume: in LAYERSPLAT_VOLUMES, or next to the repository. Skips the test if it is missing."""
    beside = pathlib.Path(__file__).parents[4] / "shared/volumes"
    volumes = pathlib.Path(os.environ.get("LAYERSPLAT_VOLUMES", beside))

    def path(name):
        found = volumes / name
        if not found.exists():
            pytest.skip(f"{found} is missing")
        return found

    return path
