"""A model of a frame on an NVIDIA H200: model.py LAYERSPLAT KERNELS.json EDITED.json

A frame is bound by what its lanes do or by what it reads:

    instructions = rays x RAY x (1 + slabs / work-items of a group) + lit segments x (LIT + DARK x DIM) + pixels x instructions of warp
    ms           = instructions / (SMs x schedulers x 32 lanes x clock) / EFFICIENCY
    bytes        = voxels of segments, each line of 32 once per group of 32 rays; lattice and picture, written and read
    ms           = bytes / bandwidth

Lit segments, rays and slabs are those of the same frame on this machine, by `layersplat bench`. RAY, LIT and DIM are instructions of
point_samples: of a ray without segments, and the additional ones of a segment that has light, or is invisible, inside the volume and
behind another segment. Each is counted in a kernel that is edited (paths.json) to have a single path. Instructions that are present but
not executed count, such as a highlight by another exponent; so do, for each segment, those that a ray needs once. RAY is counted for each
slab that a work-item looks up, though only half of its instructions do that. DARK and EFFICIENCY are assumptions.
"""

import json
import os
import subprocess
import sys

# NVIDIA H200 SXM, data sheet: SMs, boost clock in Hz, bytes per second; schedulers of an SM, each an instruction of 32 lanes per clock.
SMS, SCHEDULERS, LANES, CLOCK, BANDWIDTH = 132, 4, 32, 1.785e9, 4.8e12
# Work-items per group, which look up slabs together.
GROUP = 64
# Invisible segments sampled per visible one: more than were counted by hand in these scenes, 0.3 (dense) and 1.4 (sparse).
DARK = 1.5
# Active lanes: 0.87 of 32 neighbours (counted likewise) have light in the same slabs, and half of an SM's warps wait for memory.
EFFICIENCY = 0.4
# Voxels read per segment, shared between neighbours: 4 columns of 4 rows of a plane, one byte each.
BYTES_PER_SEGMENT = 16

SIDE = 1024
HERE = os.path.dirname(os.path.abspath(__file__))
DENSE = os.path.join(HERE, "..", "hydrogen.json")
SCENES = [("dense", 512, ["--transfer", DENSE], 4.0), ("sparse", 512, ["--opacity", "200:0,230:0.3"], 4.0),
          ("dense", 1024, ["--transfer", DENSE], 8.0), ("sparse", 1024, ["--opacity", "200:0,230:0.3"], 8.0)]


def instructions_of(kernels, name, *words):
    """Instructions of the default program of a kernel, or of an edit of it."""
    found = [k for k in kernels if k["name"] == name and "standard" in k["qualities"] and all(w in k["options"] for w in words)]
    plain = min(found, key=lambda k: len(k["options"]))
    return sum(plain["instructions"].values())


def counts_of(binary, voxels, options):
    command = [binary, "bench", f"builtin:hydrogen@{voxels}", "--size", f"{SIDE}x{SIDE}", "--frames", "1", "--json", *options]
    bench = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    return bench["active_samples"], bench["lattice"]["width"] * bench["lattice"]["height"]


def main():
    binary, (kernels, edited) = sys.argv[1], (json.load(open(path, encoding="utf-8")) for path in sys.argv[2:])
    ray, lit, dim = (
        instructions_of(edited, f"point_samples, {path}", "VOXEL=uchar", "WHOLE_LAYERS")
        for path in ("no segment", "segment with light", "segment that shows nothing")
    )
    lit, dim, pixel = lit - ray, dim - ray, instructions_of(kernels, "warp")
    rate = SMS * SCHEDULERS * LANES * CLOCK * EFFICIENCY
    print(f"instructions: {ray} a ray, {lit} a segment with light, {dim} one that shows nothing, {pixel} a pixel; {SIDE}² pixels, `standard`, lit\n")
    print("| volume | rays | lit segments | instructions, 10⁹ | ms of these | ms of memory | predicted ms | aim |\n|---|---|---|---|---|---|---|---|")
    for name, voxels, options, aim in SCENES:
        segments, rays = counts_of(binary, voxels, options)
        work = rays * ray * (1 + (voxels + 1) / GROUP) + segments * (lit + DARK * dim) + SIDE * SIDE * pixel
        moved = segments * (1 + DARK) * BYTES_PER_SEGMENT + rays * 32 + SIDE * SIDE * 4
        computing, reading = 1e3 * work / rate, 1e3 * moved / BANDWIDTH
        print(
            f"| {name}, {voxels}³ | {rays:,} | {segments:,} | {work / 1e9:.0f} | {computing:.1f} | {reading:.2f} "
            f"| {max(computing, reading):.1f} | {aim:.0f} |",
            flush=True,
        )


main()
