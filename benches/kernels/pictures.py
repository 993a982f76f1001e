"""The pictures of docs/dev/kernels.md: each data set with each kernel in `high`, and Marschner and Lobb's signal beside its reference."""

import json
import pathlib
import tempfile

import numpy
from PIL import Image, ImageDraw

from scenes import CONVERGED, ENGINE, KERNELS, ROOT, SKULL, VOLUMES, kernel_options, psnr, run

IMAGES = ROOT / "docs/dev/images"
TILE = 320
# Samples per axis of the displayed signal, and of the float volume that serves as the reference.
SAMPLED, KNOWN = 41, 241


def render(scene, kernel, options, picture):
    run("render", *scene, *kernel_options(kernel), *options, "--output", picture)
    return Image.open(picture).convert("RGB") if picture.suffix == ".png" else None


def sheet(rows, labels, name):
    """Composes labelled rows of pictures without scaling."""
    page = Image.new("RGB", (len(rows[0]) * TILE, len(rows) * TILE + 16))
    draw = ImageDraw.Draw(page)
    for column, label in enumerate(labels):
        draw.text((column * TILE + 4, 2), label, fill=(255, 255, 255))
    for j, row in enumerate(rows):
        for i, picture in enumerate(row):
            page.paste(picture, (i * TILE, 16 + j * TILE))
    page.save(IMAGES / name, optimize=True)
    print(IMAGES / name, (IMAGES / name).stat().st_size)


def magnified(scene, center, scale, zooms, name, picture):
    rows = []
    for zoom in zooms:
        view = ["--quality", "high", "--size", f"{TILE}x{TILE}", "--center", center, "--parallel-scale", scale / zoom]
        rows.append([render(scene, kernel, view, picture) for kernel in KERNELS])
    sheet(rows, KERNELS, name)


def signal_sampled(n):
    """Marschner and Lobb's signal in units of bytes, not rounded: n samples per axis, x fastest."""
    z, y, x = numpy.meshgrid(*[numpy.linspace(-1, 1, n)] * 3, indexing="ij")
    rings = numpy.cos(12 * numpy.pi * numpy.cos(numpy.pi * numpy.hypot(x, y) / 2))
    return (255 / 2.5 * (1 - numpy.sin(numpy.pi * z / 2) + 0.25 * (1 + rings))).astype("<f4")


def signal(work):
    """The scene of tests/fidelity/kernels/scene.rs. The reference has enough samples under a B-spline, ray cast in steps of 1/16."""
    opacities = [(0, 0), (40, 0), (70, 0.015), (100, 0), (0.45 * 255, 0), (0.55 * 255, 0.9), (255, 0.9)]
    colors = [0, 0.2, 0.4, 0.9, 100, 0.2, 0.6, 0.8, 128, 0.95, 0.7, 0.3, 255, 0.8, 0.3, 0.2]
    transfer = work / "rings.json"
    points = [n for value, opacity in opacities for n in (value, opacity, 0.5, 0)]
    transfer.write_text(json.dumps([{"Name": "rings", "RGBPoints": colors, "Points": points}]))
    known = work / f"signal_{KNOWN}x{KNOWN}x{KNOWN}_float32.raw"
    signal_sampled(KNOWN).tofile(known)

    def scene(volume, n, spacing):
        low, high = (f"{(n - 1) / 2 * (1 + side * 0.85):.6g}" for side in (-1, 1))
        half, crop = (n - 1) / 2 * spacing, ",".join([f"{low}:{high}"] * 3)
        view = ["--azimuth", 15, "--elevation", 35, "--center", f"{half},{half},{half}", "--parallel-scale", 1.15 * half]
        return [volume, "--spacing", ",".join([f"{spacing:.17g}"] * 3), "--transfer", transfer, *view, "--crop", crop,
                "--unit-distance", half / 32]

    sampled, fine = scene(f"builtin:marschner-lobb@{SAMPLED}", SAMPLED, 1), scene(known, KNOWN, (SAMPLED - 1) / (KNOWN - 1))
    whole = [(fine, "bspline", CONVERGED)] + [(sampled, kernel, ["--quality", "high"]) for kernel in KERNELS]
    size = ["--size", f"{TILE}x{TILE}"]
    row = [render(volume, kernel, [*how, *size], work / "a.png") for volume, kernel, how in whole]
    truth, found = work / "truth.npy", work / "found.npy"
    render(fine, "bspline", [*CONVERGED, "--size", "256x256"], truth)
    for _, kernel, how in whole[1:]:
        render(sampled, kernel, [*how, "--size", "256x256"], found)
        print(f"marschner-lobb@{SAMPLED}, lit, high, {kernel}: {psnr(found, truth):.1f} dB")
    sheet([row], ["the signal", *KERNELS], "kernels-marschner-lobb.png")


def main():
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        signal(work)
        if not VOLUMES.is_dir():
            raise SystemExit(f"{VOLUMES} does not exist: set LAYERSPLAT_VOLUMES for the other pictures")
        magnified(SKULL, "152,150,148", 70, [1, 4], "kernels-skull.png", work / "a.png")
        magnified([*ENGINE, "--azimuth", 72, "--elevation", 20], "150,190,70", 120, [1, 4], "kernels-engine.png", work / "a.png")


main()
