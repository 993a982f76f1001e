"""Frame times of 1, 2 and 4 threads by turns, and a simulation of up to 64: cores.py BINARY PRINTING_BINARY --rounds N --frames N"""

import argparse
import datetime
import heapq
import json
import math
import os
import pathlib
import re
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
VOLUMES = pathlib.Path(os.environ.get("LAYERSPLAT_VOLUMES", ROOT / "../shared/volumes"))
SETS = ["fuel", "neghip", "lobster", "engine", "aneurism"]
THREADS = [1, 2, 4]
SIMULATED = [2, 4, 8, 16, 32, 64]
# PoCL 3.1 and 6 (lib/CL/devices/pthread/pthread_scheduler.c): a thread takes its share of the work-groups that are left, at most this many
# times the number of threads.
GROUPS_PER_THREAD = 32


def bench(binary, name, threads, frames, quality):
    data = next(VOLUMES.glob(f"{name}_*uint8.raw.gz"))
    command = [binary, "bench", data, "--transfer", VOLUMES.parent / f"transfer/{name}.json", "--frames", frames, "--elevation", 20]
    command += ["--quality", quality, "--device-unchecked", "--json"]
    environment = {**os.environ, "POCL_MAX_PTHREAD_COUNT": str(threads), "POCL_CPU_MAX_CU_COUNT": str(threads)}
    if threads > os.cpu_count():
        environment["POCL_AFFINITY"] = "0"
    done = subprocess.run([str(c) for c in command], env=environment, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{command}\n{done.stderr}")
    return done.stdout


def parsed(text):
    return json.loads(text.splitlines()[-1])


def measured_row(binary, name, quality, rounds, frames):
    """A table row: medians of 1, 2 and 4 threads that take turns, and T(1) / (2 T(2))."""
    times = {n: [] for n in THREADS}
    for _ in range(rounds):
        for n in THREADS:
            times[n].append(parsed(bench(binary, name, n, frames, quality))["median_ms"])
    ratios = [one / (2 * two) for one, two in zip(times[1], times[2])]
    cells = [f"{statistics.median(times[n]):.2f}" for n in THREADS]
    return [f"{name}, `{quality}`", *cells, f"{statistics.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})"]


def frames_of_tiles(text):
    """For each frame but the first ones: the number of tiles of a row, and times of all tiles, row by row."""
    frames = []
    for item, number, width, cycles in re.findall(r"^tile (\d+) (\d+) (\d+) (\d+)$", text, re.MULTILINE):
        if item == "0":
            frames.append((int(width), {}))
        frames[-1][1][int(number)] = int(cycles)
    return [(width, [times[i] for i in range(len(times))]) for width, times in frames[2:]]


def pocl_chunk(left, threads):
    return min(GROUPS_PER_THREAD * threads, -(-left // threads))


def makespan(times, threads, chunk):
    """Time until all tiles are done, if threads that have nothing to do take `chunk(tiles left, threads)` tiles."""
    free = [0] * threads
    done = 0
    while done < len(times):
        count = chunk(len(times) - done, threads)
        heapq.heapreplace(free, free[0] + sum(times[done : done + count]))
        done += count
    return max(free)


def in_runs(length):
    """The order of kernels/layered/tile.cl, as src/renderer/tiles.rs chooses its steps."""

    def order(_, times):
        runs = max(len(times) // length, 1)
        step = math.ceil(runs * (math.sqrt(5) - 1) / 2)
        while math.gcd(step, runs) != 1:
            step += 1
        numbers = [run * step % runs * length + i for run in range(runs) for i in range(length)]
        return [times[i] for i in numbers + list(range(runs * length, len(times)))]

    return order


def middle_last(width, times):
    """Rows of tiles from the top and then from the bottom to the middle: the order before runs."""
    rows = [times[i : i + width] for i in range(0, len(times), width)]
    above = len(rows) // 2
    return [t for row in rows[:above] + rows[above:][::-1] for t in row]


def halved(width, times):
    """Two tiles of half the rows instead of each, which together take 1.13 times as long (docs/dev/performance.md: 17.4 to 15.4 ms)."""
    return [t * 17.4 / 15.4 / 2 for t in in_runs(1)(width, times) for _ in range(2)]


ORDERS = [
    ("single tiles, as with more than two threads", in_runs(1), pocl_chunk),
    ("runs of 8, as with two", in_runs(8), pocl_chunk),
    ("middle of the picture last, as before", middle_last, pocl_chunk),
    ("from top to bottom", lambda width, times: times, pocl_chunk),
    ("single tiles of 8 rows", halved, pocl_chunk),
    ("single tiles, if threads took one at a time", in_runs(1), lambda left, threads: 1),
]


def simulated_rows(binary, name, frames):
    text = bench(binary, name, 1, frames, "standard")
    tiles = frames_of_tiles(text)
    alone = sum(sum(times) for _, times in tiles)
    rows = []
    for how, order, chunk in ORDERS:
        efficiencies = []
        for threads in SIMULATED:
            together = sum(makespan(order(width, times), threads, chunk) for width, times in tiles)
            efficiencies.append(f"{alone / (threads * together):.2f}")
        rows.append([name, how, *efficiencies])
    largest = sum(max(times) for _, times in tiles) / alone
    count = statistics.median(len(times) for _, times in tiles)
    return rows, [name, f"{count:.0f}", f"{100 * largest:.1f} %", f"{1 / largest:.0f}"]


def table(head, rows):
    return "\n".join("| " + " | ".join(r) + " |" for r in [head, ["---"] * len(head), *rows])


def serial_row(binary, name, frames):
    """Milliseconds of a frame of one thread, of its kernels, and of the rest."""
    told = parsed(bench(binary, name, 1, frames, "standard"))
    kernels = sum(told["stages"].values())
    serial = max(told["median_ms"] - kernels, 0.0)
    return [name, f"{told['median_ms']:.2f}", f"{kernels:.2f}", f"{serial:.2f}"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("binary", type=pathlib.Path)
    parser.add_argument("printing", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--frames", type=int, default=25)
    options = parser.parse_args()
    measured = [measured_row(options.binary, name, quality, options.rounds, options.frames)
                for quality in ["standard", "high"] for name in SETS]
    simulated, largest = [], []
    for name in SETS:
        rows, most = simulated_rows(options.printing, name, options.frames)
        simulated += rows
        largest.append(most)
    text = "\n\n".join([
        f"Printed by `benches/cores/run` on {datetime.date.today()}: {os.cpu_count()} cores; medians in ms of {options.rounds} rounds of "
        f"{options.frames} frames, 512², lit, in which 1, 2 and 4 threads took turns. Efficiency: the median of T(1) / (2 T(2)), and its range.",
        table(["", "1 thread", "2", "4", "efficiency of 2"], measured),
        "Efficiency of the lattice kernel with more threads, by simulation: times of all tiles of a turn on one thread, `standard`, lit, and "
        "PoCL's rule for how many tiles a thread takes.",
        table(["", "order of tiles", *[f"{n}" for n in SIMULATED]], simulated),
        "What the tiles allow at most: a frame takes at least as long as its most expensive tile.",
        table(["", "tiles", "most expensive tile", "threads that it allows"], largest),
        "What a frame of one thread takes outside of kernels, ms:",
        table(["", "frame", "kernels", "the rest"], [serial_row(options.binary, name, options.frames) for name in SETS]),
    ])
    print(text)
    page = ROOT / "docs/dev/performance.md"
    begin, end = "<!-- cores -->\n", "\n<!-- /cores -->"
    before, rest = page.read_text().split(begin)
    page.write_text(before + begin + text + end + rest.split(end)[1])


main()
