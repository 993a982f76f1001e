"""Frame times of two binaries that take turns: times.py BEFORE AFTER

Prints milliseconds of both and their ratio, and the ratio of their CPU times, which other work on the machine disturbs less: medians of
three rounds of `bench` each, per data set and way of rendering.
"""

import json
import os
import pathlib
import statistics
import subprocess
import sys

ROUNDS = 3
VOLUMES = pathlib.Path(os.environ.get("LAYERSPLAT_VOLUMES", "../shared/volumes"))
TRANSFERS = VOLUMES.parent / "transfer"
SETS = {"fuel": "fuel_64x64x64_uint8", "lobster": "lobster_301x324x56_uint8", "engine": "engine_256x256x128_uint8", "aneurism": "aneurism_256x256x256_uint8"}
WAYS = {
    "draft": ["--quality", "draft", "--frames", "25"], "standard": ["--frames", "25"], "high": ["--quality", "high", "--frames", "13"],
    "standard, unlit": ["--shading", "off", "--frames", "25"], "post": ["--classification", "post", "--frames", "13"],
    "perspective": ["--perspective", "35", "--frames", "25"], "post, perspective": ["--classification", "post", "--perspective", "35", "--frames", "5"],
    "raycast": ["--algorithm", "raycast", "--frames", "5"], "slicing": ["--algorithm", "slicing", "--frames", "5"],
    "view-sheets": ["--algorithm", "view-sheets", "--frames", "3"], "axis-sheets": ["--algorithm", "axis-sheets", "--frames", "5"],
    "direct": ["--lattice", "direct", "--frames", "3"],
}


def times_of(binary, volume, transfer, options):
    done = subprocess.run([binary, "bench", volume, "--transfer", transfer, *options, "--json"], capture_output=True, text=True, check=True)
    bench = json.loads(done.stdout)
    return bench["median_ms"], bench["cpu_ms"]


def main():
    binaries, ratios = sys.argv[1:3], []
    for way, options in WAYS.items():
        for name, file in SETS.items():
            volume, transfer = str(VOLUMES / f"{file}.raw.gz"), str(TRANSFERS / f"{name}.json")
            times = [[], []]
            for _ in range(ROUNDS):
                for binary, measured in zip(binaries, times):
                    measured.append(times_of(binary, volume, transfer, options))
            (before, cpu_before), (after, cpu_after) = ([statistics.median(column) for column in zip(*measured)] for measured in times)
            ratios.append((after / before, cpu_after / cpu_before))
            wall, cpu = ratios[-1]
            print(f"{way:18} {name:9} {before:9.2f} {after:9.2f} ms  {wall:.3f}  CPU {cpu:.3f}", flush=True)
    for what, column in zip(("wall", "CPU"), zip(*ratios)):
        print(f"{what}: median ratio {statistics.median(column):.3f}, largest {max(column):.3f}")


main()
