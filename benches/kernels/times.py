"""Times of every kernel compared with the cubic's, measured alternately: times.py [ROUNDS] [lit] [unlit] [prefilter] [WAY...]

CPU time per frame, which is less sensitive to other load, and the fastest frame; each is the minimum over all rounds. Then the cost of the
B-spline's prefilter: the first frame minus a later one, with the B-spline and with the cubic.
"""

import json
import sys

from scenes import ANEURISM, ENGINE, KERNELS, NEGHIP, WAYS, kernel_options, run, table

ROUNDS = int(sys.argv[1]) if len(sys.argv) > 1 else 4
ASKED = set(sys.argv[2:]) or {"lit", "unlit", "prefilter"}
FRAMES = 8
SETS = {"neghip": NEGHIP, "engine": ENGINE, "aneurism": ANEURISM}


def bench(scene, kernel, options, frames=FRAMES):
    return json.loads(run("bench", *scene, *kernel_options(kernel), *options, "--frames", frames, "--json"))


def least(benches, what):
    return min(b[what] for b in benches)


def frames():
    for lit in ASKED & {"lit", "unlit"}:
        rows = []
        for way, options in WAYS.items():
            if ASKED & set(WAYS) and way not in ASKED:
                continue
            found = {(name, kernel): [] for name in SETS for kernel in KERNELS}
            for _ in range(ROUNDS):
                for (name, kernel), benches in found.items():
                    benches.append(bench(SETS[name], kernel, [*options, "--shading", "on" if lit == "lit" else "off"]))
            for kernel in KERNELS:
                row = [way, kernel]
                for name in SETS:
                    cpu, wall = ([least(found[name, k], what) for k in (kernel, "cubic")] for what in ("cpu_ms", "min_ms"))
                    row.append(f"{cpu[0]:.1f}" if kernel == "cubic" else f"{cpu[0] / cpu[1]:.2f} ({wall[0] / wall[1]:.2f})")
                rows.append(row)
                print(lit, " ".join(row), file=sys.stderr, flush=True)
        print(table([lit, "", *SETS], rows) + "\n", flush=True)


def prefilter():
    for name in ("neghip", "aneurism"):
        found = {kernel: [] for kernel in ("cubic", "bspline")}
        for _ in range(2 * ROUNDS):
            for kernel, benches in found.items():
                benches.append(bench(SETS[name], kernel, [], 1))
        first = {kernel: min(b["first_ms"] - b["min_ms"] for b in benches) for kernel, benches in found.items()}
        memory = {kernel: benches[0]["device_bytes"] for kernel, benches in found.items()}
        print(f"{name}: the first frame less another, {first['cubic']:.0f} ms with cubic, {first['bspline']:.0f} with bspline: "
              f"{first['bspline'] - first['cubic']:.0f} ms more; device memory {memory['cubic']} and {memory['bspline']} bytes")


frames()
if "prefilter" in ASKED:
    prefilter()
