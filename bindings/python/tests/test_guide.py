"""Runs the Python of the README and of the guide, and compares the picture that both show."""

import pathlib
import re
import shutil

import matplotlib.image
import numpy
import pytest

import layersplat

ROOT = pathlib.Path(__file__).parents[3]
PAGES = ["README.md", "docs/guide/python.md", "docs/guide/surfaces.md"]
BLOCKS = [(page, block) for page in PAGES for block in re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.S)]
# dB; other processors and OpenCL implementations change last bits.
LEAST_PSNR = 45


def psnr(a, b):
    error = numpy.mean((a.astype(float) - b) ** 2)
    return numpy.inf if error == 0 else -10 * numpy.log10(error)


@pytest.mark.parametrize("page, block", BLOCKS, ids=[f"{page}-{n}" for n, (page, _) in enumerate(BLOCKS)])
def test_blocks(page, block, tmp_path, monkeypatch):
    shutil.copy(ROOT / "examples/data/brain.nii.gz", tmp_path)
    monkeypatch.chdir(tmp_path)
    known = {}
    exec(block, known)
    if (tmp_path / "field.png").exists():
        ours, shown = (matplotlib.image.imread(folder / "field.png") for folder in (tmp_path, ROOT / "docs/guide/images"))
        assert psnr(ours, shown) > LEAST_PSNR
        assert psnr(numpy.roll(ours, 2, axis=0), shown) < LEAST_PSNR, "a shift by two pixels is noticed"
    else:
        assert known["picture"].shape[2] == 4 and known["picture"].max() > 0


def test_readme_has_python():
    assert [page for page, _ in BLOCKS].count("README.md") == 1 and layersplat.__version__
