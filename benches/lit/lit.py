"""The pictures of docs/dev/lit.md; benches/lit/run calls it."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from PIL import Image, ImageDraw  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
VOLUMES = pathlib.Path(os.environ.get("LAYERSPLAT_VOLUMES", ROOT.parent / "shared/volumes"))
IMAGES = ROOT / "docs/dev/images"
LAYERSPLAT = ROOT / "target/release/layersplat"
CONVERGED = ["--algorithm", "raycast", "--kernel", "cubic", "--gradient", "sobel", "--step", 0.0625]
TILE = 190

SKULL = ["cranium_ct_256x256x108_int16.raw.gz", "--transfer", VOLUMES / "../transfer/cranium_ct_int16.json"]
SKULL += ["--spacing", "0.957,0.957,1.5", "--up", "y", "--azimuth", 30, "--elevation", 20, "--center", "152,150,148"]
ENGINE = ["engine_256x256x128_uint8.raw.gz", "--transfer", VOLUMES / "../transfer/engine.json"]
ENGINE += ["--azimuth", 72, "--elevation", 20, "--center", "150,190,70"]


def run(binary, *arguments):
    result = subprocess.run([str(a) for a in (binary, *arguments)], capture_output=True, text=True)
    if result.returncode:
        sys.exit(f"{arguments}\n{result.stderr}")
    return result.stdout


def render(binary, volume, options, picture):
    run(binary, "render", volume, *options, "--output", picture)
    return Image.open(picture).convert("RGB")


def sheet(rows, labels, path):
    """Composes labelled rows of pictures in 256 colours."""
    width, height = len(rows[0]) * TILE, len(rows) * TILE
    page = Image.new("RGB", (width, height + 14))
    draw = ImageDraw.Draw(page)
    for column, label in enumerate(labels):
        draw.text((column * TILE + 4, 1), label, fill=(255, 255, 255))
    for j, row in enumerate(rows):
        for i, picture in enumerate(row):
            page.paste(picture.resize((TILE, TILE), Image.LANCZOS), (i * TILE, 14 + j * TILE))
    page.quantize(256).save(path, optimize=True)
    print(path)


def magnified(name, scene, scale, before, work):
    """At 1, 4 and 10 times the scale: standard and high, an older build if given, and ray casting."""
    volume, options = VOLUMES / scene[0], scene[1:]
    columns = [(f"before: {q}", before, ["--quality", q]) for q in ("standard", "high")] if before else []
    columns += [(q, LAYERSPLAT, ["--quality", q]) for q in ("standard", "high")]
    columns += [("ray casting, steps of 1/16", LAYERSPLAT, CONVERGED)]
    rows = []
    for zoom in (1, 4, 10):
        view = [*options, "--size", "380x380", "--parallel-scale", scale / zoom]
        rows.append([render(binary, volume, [*view, *how], work / "a.png") for _, binary, how in columns])
    sheet(rows, [c[0] for c in columns], IMAGES / f"lit-{name}.png")


def convergence(work):
    """PSNR to the integral per pixel, by samples per layer, lit and unlit."""
    figure, axes = plt.subplots(figsize=(5.2, 3.4), constrained_layout=True)
    volumes = ["builtin:hydrogen@48", "builtin:marschner-lobb@48"]
    for volume, color in zip(volumes, ["#1f6f8b", "#b5651d"]):
        for shading, line in [("on", "o-"), ("off", "o:")]:
            view = ["--transfer", "fire", "--size", "160x160", "--azimuth", 40, "--elevation", 25, "--shading", shading]
            truth, found = work / "truth.npy", work / "found.npy"
            run(LAYERSPLAT, "render", volume, *view, *CONVERGED[:-1], 0.015625, "--output", truth)
            psnr = []
            for samples in range(1, 9):
                run(LAYERSPLAT, "render", volume, *view, "--lattice", "direct", "--sublayers", samples, "--output", found)
                psnr.append(json.loads(run(LAYERSPLAT, "compare", found, truth, "--json"))["psnr"])
            label = f"{volume.split(':')[1]}, {'lit' if shading == 'on' else 'unlit'}"
            axes.plot(range(1, 9), psnr, line, color=color, label=label)
            print(label, " ".join(f"{p:.1f}" for p in psnr))
    axes.set_xlabel("samples per layer")
    axes.set_ylabel("PSNR to the integral, dB")
    axes.set_xscale("log", base=2)
    axes.set_xticks([1, 2, 3, 4, 6, 8], ["1", "2", "3", "4", "6", "8"])
    axes.grid(True, color="#dddddd")
    axes.legend(fontsize=7)
    figure.savefig(IMAGES / "convergence.png", dpi=110)


def first_pictures(work):
    files = sorted(VOLUMES.glob("*.raw.gz"))
    pictures = [render(LAYERSPLAT, file, ["--size", "380x380"], work / "a.png") for file in files]
    while len(pictures) % 5:
        pictures.append(Image.new("RGB", (TILE, TILE)))
    sheet([pictures[i : i + 5] for i in range(0, len(pictures), 5)], [], IMAGES / "first-pictures.png")


def main():
    before = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else None
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        convergence(work)
        if not VOLUMES.is_dir():
            sys.exit(f"{VOLUMES} does not exist: set LAYERSPLAT_VOLUMES for the other pictures")
        first_pictures(work)
        magnified("skull", SKULL, 70, before, work)
        magnified("engine", ENGINE, 120, before, work)


main()
