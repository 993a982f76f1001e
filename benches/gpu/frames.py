"""Frames of 1024² on one device: frames.py BINARY DEVICE. Prints Markdown tables; see run."""

import json
import os
import subprocess
import sys

SIDE, FRAMES = 1024, 31
HERE = os.path.dirname(os.path.abspath(__file__))
DENSE = ["--transfer", os.path.join(HERE, "..", "hydrogen.json")]
SPARSE = ["--opacity", "200:0,230:0.3"]
BUILT_IN = [
    ("hydrogen 512³, dense", ["builtin:hydrogen@512", *DENSE]),
    ("hydrogen 512³, sparse", ["builtin:hydrogen@512", *SPARSE]),
    ("hydrogen 1024³, dense", ["builtin:hydrogen@1024", *DENSE]),
    ("hydrogen 1024³, sparse", ["builtin:hydrogen@1024", *SPARSE]),
]
DATA_SETS = [("engine", "engine_256x256x128_uint8.raw.gz"), ("aneurism", "aneurism_256x256x256_uint8.raw.gz"),
             ("brain", "colin27_hires_301x370x316_uint8.raw.gz")]
SETTINGS = [
    ("`draft`", ["--quality", "draft"]),
    ("`standard`", []),
    ("perspective of 30°", ["--perspective", "30"]),
    ("shadows", ["--shadows", "on"]),
    ("ambient occlusion", ["--ambient-occlusion", "on"]),
    ("`high`", ["--quality", "high"]),
    ("ray casting, step 0.5", ["--algorithm", "raycast"]),
    ("splatted (`post`)", ["--classification", "post"]),
]


def bench(binary, device, options):
    command = [binary, "bench", "--size", f"{SIDE}x{SIDE}", "--frames", str(FRAMES), "--json", *device, *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(command)}: {done.stderr}")
    return json.loads(done.stdout)


def kernels(report):
    """The kernels' part of a frame in ms, as the device's events report it."""
    return sum(report["stages"].values())


def volumes():
    folder = os.environ.get("LAYERSPLAT_VOLUMES", os.path.join(HERE, "..", "..", "..", "shared", "volumes"))
    for name, file in DATA_SETS:
        path = os.path.join(folder, file)
        if os.path.exists(path):
            yield name, [path]
        else:
            print(f"left out, no file {path}", file=sys.stderr)
    yield BUILT_IN[0]


def main():
    binary, device = sys.argv[1], ["--device", sys.argv[2]] if sys.argv[2] else []
    scenes = [(name, bench(binary, device, options)) for name, options in BUILT_IN]
    print(f"{scenes[0][1]['device']}; {SIDE}², lit, medians of {FRAMES} views in ms: the whole frame (its kernels)\n")
    print("| `standard` | active samples | frame (kernels) | new transfer function | new layer axis |\n|---|---|---|---|---|")
    for name, report in scenes:
        print(f"| {name} | {report['active_samples']:,} | {report['median_ms']:.1f} ({kernels(report):.1f}) "
              f"| {report['transfer_change_ms']:.1f} | {report['axis_change_ms']:.1f} |")
    chosen = list(volumes())
    print("\n| | " + " | ".join(name for name, _ in chosen) + " |\n|---" + "|---" * len(chosen) + "|")
    for name, options in SETTINGS:
        reports = [bench(binary, device, [*volume, *options]) for _, volume in chosen]
        print(f"| {name} | " + " | ".join(f"{r['median_ms']:.1f} ({kernels(r):.1f})" for r in reports) + " |", flush=True)


main()
