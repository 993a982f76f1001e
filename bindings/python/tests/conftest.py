"""What the tests share: a volume that looks different from every side, and the command to compare with."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import layersplat

SIZE = (72, 60)


@pytest.fixture(scope="session")
def array():
    """(z, y, x) = (20, 24, 28), uint8: smooth, of no symmetry."""
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
    """Runs the command `layersplat`: LAYERSPLAT_COMMAND, which ./test builds."""
    path = os.environ.get("LAYERSPLAT_COMMAND")
    if not path:
        pytest.skip("LAYERSPLAT_COMMAND names no command to compare with")

    def run(*arguments):
        subprocess.run([path, *map(str, arguments)], check=True, capture_output=True, timeout=300)

    return run


@pytest.fixture(scope="session")
def picture():
    """The picture of a volume, with as much given as makes two of them comparable."""

    def of(data, spacing=None, **given):
        given = {"cmap": "fire", "clim": (0, 255), "size": SIZE, "background": "transparent", **given}
        found = layersplat.render(data, spacing, **given)
        assert found[..., :3].max() > 20, "something is seen"
        return found

    return of


@pytest.fixture(scope="session")
def shared():
    """The path of a real volume: in LAYERSPLAT_VOLUMES, or beside the repository. Without it a test is skipped."""
    beside = pathlib.Path(__file__).parents[4] / "shared/volumes"
    volumes = pathlib.Path(os.environ.get("LAYERSPLAT_VOLUMES", beside))

    def path(name):
        found = volumes / name
        if not found.exists():
            pytest.skip(f"{found} is not there")
        return found

    return path
