"""Frame times of two binaries, measured alternately: times.py BEFORE AFTER

Prints milliseconds of both, their ratio, and the ratio of their CPU times, which are less sensitive to other load: medians of three rounds
of `bench` each, per data set and algorithm, per kind of view, and per voxel type. Also prints the ratios for a new transfer function,
another layer axis and the first frame.
"""

import array
import gzip
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROUNDS = 3
VOLUMES = pathlib.Path(os.environ.get("LAYERSPLAT_VOLUMES", "../shared/volumes"))
TRANSFERS = VOLUMES.parent / "transfer"
SETS = {
    "fuel": "fuel_64x64x64_uint8", "neghip": "neghip_64x64x64_uint8", "lobster": "lobster_301x324x56_uint8", "engine": "engine_256x256x128_uint8",
    "aneurism": "aneurism_256x256x256_uint8",
}
WAYS = {
    "draft": ["--quality", "draft", "--frames", "25"], "standard": ["--frames", "25"], "high": ["--quality", "high", "--frames", "13"],
    "standard, unlit": ["--shading", "off", "--frames", "25"], "post": ["--classification", "post", "--frames", "13"],
    "perspective": ["--perspective", "35", "--frames", "25"], "post, perspective": ["--classification", "post", "--perspective", "35", "--frames", "5"],
    "raycast": ["--algorithm", "raycast", "--frames", "5"], "slicing": ["--algorithm", "slicing", "--frames", "5"],
    "view-sheets": ["--algorithm", "view-sheets", "--frames", "3"], "axis-sheets": ["--algorithm", "axis-sheets", "--frames", "5"],
    "direct": ["--lattice", "direct", "--frames", "3"],
}


def of_set(name):
    return [str(VOLUMES / f"{SETS[name]}.raw.gz"), "--transfer", str(TRANSFERS / f"{name}.json")]


VIEWS = {
    "64 x 64, engine": [*of_set("engine"), "--size", "64x64"], "64 x 64, neghip": [*of_set("neghip"), "--size", "64x64"],
    "2048 x 2048, engine": [*of_set("engine"), "--size", "2048x2048"], "2048 x 2048, neghip": [*of_set("neghip"), "--size", "2048x2048"],
    "rolled, engine": [*of_set("engine"), "--roll", "20"], "rolled, from above, lobster": [*of_set("lobster"), "--elevation", "60", "--roll", "10"],
    "from above, aneurism": [*of_set("aneurism"), "--elevation", "60"], "spacing 1,1,3, engine": [*of_set("engine"), "--spacing", "1,1,3"],
    "int16, cranium": [str(VOLUMES / "cranium_ct_256x256x108_int16.raw.gz"), "--transfer", "grey", "--spacing", "0.957,0.957,1.5"],
}
FIELDS = {"median_ms": "wall", "cpu_ms": "CPU", "transfer_change_ms": "new transfer function", "axis_change_ms": "new axis", "first_ms": "first frame"}


def of_floats(folder, name):
    """Writes the same numbers in another type to a separate file."""
    file = pathlib.Path(folder) / f"{SETS[name].replace('uint8', 'float32')}.raw"
    with gzip.open(VOLUMES / f"{SETS[name]}.raw.gz") as voxels, open(file, "wb") as floats:
        array.array("f", array.array("B", voxels.read())).tofile(floats)
    return [str(file), *of_set(name)[1:]]


def bench(binary, options):
    done = subprocess.run([binary, "bench", *options, "--json"], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def compare(binaries, options):
    """Medians of both in each field."""
    runs = [[], []]
    for _ in range(ROUNDS):
        for binary, own in zip(binaries, runs):
            own.append(bench(binary, options))
    return [{field: statistics.median(run[field] for run in own) for field in FIELDS} for own in runs]


def main(binaries, folder):
    ratios = []
    views = {**VIEWS, "float32, engine": of_floats(folder, "engine")}
    cases = [(f"{way:18} {name:9}", of_set(name) + options, 2) for way, options in WAYS.items() for name in SETS]
    cases += [(f"{view:28}", [*options, "--frames", "9"], len(FIELDS)) for view, options in views.items()]
    for what, options, fields in cases:
        before, after = compare(binaries, options)
        ratio = {field: after[field] / before[field] for field in list(FIELDS)[:fields]}
        ratios.append(ratio)
        told = "  ".join(f"{FIELDS[field]} {value:.3f}" for field, value in ratio.items())
        print(f"{what} {before['median_ms']:9.2f} {after['median_ms']:9.2f} ms  {told}", flush=True)
    for field, name in FIELDS.items():
        column = [ratio[field] for ratio in ratios if field in ratio]
        print(f"{name}: median ratio {statistics.median(column):.3f}, largest {max(column):.3f}")


with tempfile.TemporaryDirectory() as folder:
    main(sys.argv[1:3], folder)
