"""A model of a frame on an NVIDIA H200: model.py LAYERSPLAT KERNELS.json

A frame is bound by what its lanes do or by what it reads. Both are counted from above:

    instructions = rays x slabs x SKIP + lit segments x (1 + DARK) x instructions of point_samples + pixels x instructions of warp
    ms           = instructions / (SMs x schedulers x 32 lanes x clock) / EFFICIENCY
    bytes        = voxels of lit segments, each line of 32 once per group of 32 rays; lattice and picture, written and read
    ms           = bytes / bandwidth

Lit segments, rays and slabs are what the same frame has here, by `layersplat bench`. As instructions of point_samples count all that
the compiler made of it, though a segment passes the edge's way or the inner one, not both. SKIP, DARK and EFFICIENCY are assumptions.
"""

import json
import os
import subprocess
import sys

# NVIDIA H200 SXM, data sheet: SMs, boost clock in Hz, bytes per second; schedulers of an SM, each an instruction of 32 lanes per clock.
SMS, SCHEDULERS, LANES, CLOCK, BANDWIDTH = 132, 4, 32, 1.785e9, 4.8e12
# Instructions that see that a slab shows nothing: an index, a byte, a bit.
SKIP = 25
# Segments that are sampled and show nothing, for each that does: on engine, of tiles, 0.4.
DARK = 1
# Lanes at work: neighbouring rays end and skip apart, and eight warps of an SM's sixteen wait for memory.
EFFICIENCY = 0.4
# A segment's voxels, of which neighbours share: 4 columns of 4 rows of a plane, of bytes.
BYTES_PER_SEGMENT = 16

SIDE = 1024
HERE = os.path.dirname(os.path.abspath(__file__))
DENSE = os.path.join(HERE, "..", "hydrogen.json")
SCENES = [("dense", 512, ["--transfer", DENSE], 4.0), ("sparse", 512, ["--opacity", "200:0,230:0.3"], 4.0),
          ("dense", 1024, ["--transfer", DENSE], 8.0), ("sparse", 1024, ["--opacity", "200:0,230:0.3"], 8.0)]


def instructions_of(kernels, name, words=()):
    """Instructions of the default's program of a kernel."""
    found = [k for k in kernels if k["kernel"] == name and "standard" in k["qualities"] and all(w in k["options"] for w in words)]
    plain = min(found, key=lambda k: len(k["options"]))
    return sum(plain["instructions"].values())


def counts_of(binary, voxels, options):
    command = [binary, "bench", f"builtin:hydrogen@{voxels}", "--size", f"{SIDE}x{SIDE}", "--frames", "1", "--json", *options]
    bench = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    return bench["active_samples"], bench["lattice"]["width"] * bench["lattice"]["height"]


def main():
    binary, kernels = sys.argv[1], json.load(open(sys.argv[2], encoding="utf-8"))
    segment, pixel = instructions_of(kernels, "point_samples", ["VOXEL=uchar"]), instructions_of(kernels, "warp", ["PRESENT"])
    rate = SMS * SCHEDULERS * LANES * CLOCK * EFFICIENCY
    print(f"point_samples: {segment} instructions, warp: {pixel}; {SIDE}² pixels, `standard`, lit\n")
    print("| volume | rays | lit segments | instructions, 10⁹ | ms of these | ms of memory | predicted ms | aim |\n|---|---|---|---|---|---|---|---|")
    for name, voxels, options, aim in SCENES:
        lit, rays = counts_of(binary, voxels, options)
        work = rays * (voxels + 1) * SKIP + lit * (1 + DARK) * segment + SIDE * SIDE * pixel
        moved = lit * (1 + DARK) * BYTES_PER_SEGMENT + rays * 32 + SIDE * SIDE * 4
        computing, reading = 1e3 * work / rate, 1e3 * moved / BANDWIDTH
        print(f"| {name}, {voxels}³ | {rays:,} | {lit:,} | {work / 1e9:.0f} | {computing:.1f} | {reading:.2f} | {max(computing, reading):.1f} | {aim:.0f} |",
              flush=True)


main()
