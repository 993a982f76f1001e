"""Data sets, views and commands of benches/kernels."""

import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
VOLUMES = pathlib.Path(os.environ.get("LAYERSPLAT_VOLUMES", ROOT.parent / "shared/volumes"))
TRANSFERS = VOLUMES.parent / "transfer"
LAYERSPLAT = ROOT / "target/release/layersplat"
# Kernels with the gradients that fit them most closely.
CLOSEST = {"cubic": "central", "linear": "central", "catmull-rom": "own", "bspline": "own"}
KERNELS = list(CLOSEST)
WAYS = {q: ["--quality", q] for q in ("draft", "standard", "high")} | {"ray casting": ["--algorithm", "raycast"]}
CONVERGED = ["--algorithm", "raycast", "--step", 0.0625]
FITTED = ["--azimuth", 72, "--elevation", 20, "--fit", "volume"]


def data_set(file, transfer, *options):
    return [VOLUMES / f"{file}.raw.gz", "--transfer", TRANSFERS / f"{transfer}.json", *options]


ENGINE = data_set("engine_256x256x128_uint8", "engine")
ANEURISM = data_set("aneurism_256x256x256_uint8", "aneurism")
NEGHIP = data_set("neghip_64x64x64_uint8", "neghip")
SKULL = data_set("cranium_ct_256x256x108_int16", "cranium_ct_int16", "--spacing", "0.957,0.957,1.5", "--up", "y", "--azimuth", 30, "--elevation", 20)


def kernel_options(kernel):
    return ["--kernel", kernel, "--gradient", CLOSEST[kernel]]


def run(*arguments):
    result = subprocess.run([str(a) for a in (LAYERSPLAT, *arguments)], capture_output=True, text=True)
    if result.returncode:
        sys.exit(f"{arguments}\n{result.stderr}")
    return result.stdout


def psnr(one, other):
    return json.loads(run("compare", one, other, "--json"))["psnr"]


def table(head, rows):
    return "\n".join("| " + " | ".join(r) + " |" for r in [head, ["---"] * len(head), *rows])
