"""Runs layersplat and its peers alternately on the same pictures, and writes the table of docs/dev/performance.md.

First the pictures must agree, since times of different pictures are not comparable.
"""

import argparse
import datetime
import gzip
import json
import math
import os
import pathlib
import platform
import re
import statistics
import subprocess
import sys

from PIL import Image, ImageChops

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = pathlib.Path(__file__).resolve().parent
LAYERSPLAT = ROOT / "target/release/layersplat"
VOLUMES = pathlib.Path(os.environ.get("LAYERSPLAT_VOLUMES", ROOT / "../shared/volumes"))
SETS = ["fuel", "neghip", "lobster", "engine", "aneurism"]
FRAME = 5  # of 25: azimuth 72
# Least PSNR over RGB between layersplat's standard and a peer's unshaded picture. VTK interpolates trilinearly; VolPack classifies before
# interpolation, which makes its picture soft. Both must also be closer than layersplat's own picture shifted by SHIFT pixels.
AGREE = {"vtk": 33.0, "volpack": 23.0}
SHIFT = 4

# Rows of the table: title, layersplat's options, the peer and its options, and the target ratio.
CASES = [
    ("`standard`, shaded : VTK, step 1", ["--quality", "standard"], "vtk", ["--step", "1", "--shaded"]),
    ("`standard`, unshaded : VTK, step 1", ["--quality", "standard", "--shading", "off"], "vtk", ["--step", "1"]),
    ("`high`, shaded : VTK, step 0.5", ["--quality", "high"], "vtk", ["--step", "0.5", "--shaded"]),
    ("`high --kernel cubic`, shaded : VTK, step 0.5", ["--quality", "high", "--kernel", "cubic"], "vtk", ["--step", "0.5", "--shaded"]),
    ("`draft`, shaded : VolPack", ["--quality", "draft"], "volpack", [1]),
    ("`standard`, perspective 30° : parallel", ["--quality", "standard", "--perspective", "30"], "layersplat", []),
]


class DataSet:
    """A volume and its transfer function, also in the peers' formats."""

    def __init__(self, name, work):
        self.name = name
        packed = next(VOLUMES.glob(f"{name}_*uint8.raw.gz"))
        self.raw = work / packed.name[: -len(".gz")]
        if not self.raw.exists():
            self.raw.write_bytes(gzip.decompress(packed.read_bytes()))
        self.dims = re.search(r"_(\d+)x(\d+)x(\d+)_", self.raw.name).groups()
        self.transfer = VOLUMES / f"../transfer/{name}.json"
        self.table = work / f"{name}.table"
        self.table.write_text(volpack_table(json.loads(self.transfer.read_text())[0]))


def volpack_table(preset):
    def points(flat, width):
        return [flat[i : i + width] for i in range(0, len(flat), width)]

    def at(value, points, column):
        for (a, b) in zip(points, points[1:]):
            if a[0] <= value < b[0]:
                return a[column] + (b[column] - a[column]) * (value - a[0]) / (b[0] - a[0])
        return points[0][column] if value < points[0][0] else points[-1][column]

    colors, opacities = points(preset["RGBPoints"], 4), points(preset["Points"], 4)
    rows = ([at(v, colors, 1), at(v, colors, 2), at(v, colors, 3), at(v, opacities, 1)] for v in range(256))
    return "".join("%.6f %.6f %.6f %.6f\n" % tuple(row) for row in rows)


def output(command):
    result = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if result.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{result.stdout}{result.stderr}")
    return result.stdout


def bench(data, options, frames):
    command = [LAYERSPLAT, "bench", data.raw, "--transfer", data.transfer, "--frames", frames, "--json", *options]
    return json.loads(output(command).splitlines()[-1])


def peer(which, data, options, frames, work, picture=None):
    """One run of a peer; `picture` is the path of a PNG of its frame FRAME."""
    if which == "layersplat":
        return bench(data, options, frames)
    if which == "vtk":
        command = [sys.executable, HERE / "vtk_frames.py", data.raw, data.transfer, "--frames", frames, *options]
        command += ["--picture", FRAME, picture] if picture else []
        return json.loads(output(command).splitlines()[-1])
    ppm = work / "volpack.ppm"
    command = [work / "volpack_frames", data.raw, *data.dims, data.table, frames, *options]
    command += [FRAME, ppm] if picture else []
    result = json.loads(output(command).splitlines()[-1])
    if picture:
        Image.open(ppm).save(picture)
    return result


def psnr(a, b):
    return float(re.search(r"PSNR RGB +([\d.]+)", output([LAYERSPLAT, "compare", a, b]))[1])


def agreement(data, frames, work):
    """PSNR between the peers' unshaded pictures and layersplat's."""
    ours = work / f"{data.name}_layersplat.png"
    azimuth = 360 * FRAME / frames
    view = ["--azimuth", azimuth, "--elevation", 20, "--fit", "volume", "--shading", "off"]
    output([LAYERSPLAT, "render", data.raw, "--transfer", data.transfer, *view, "-o", ours])
    moved = work / f"{data.name}_moved.png"
    ImageChops.offset(Image.open(ours), SHIFT, 0).save(moved)
    found = {}
    for which, options in [("vtk", ["--step", "0.5"]), ("volpack", [0])]:
        theirs = work / f"{data.name}_{which}.png"
        peer(which, data, options, frames, work, theirs)
        found[which] = psnr(theirs, ours)
        least = max(AGREE[which], psnr(moved, ours))
        if found[which] < least:
            sys.exit(f"{data.name}: {which}'s picture is {found[which]} dB from layersplat's, {least} expected: {theirs}, {ours}")
    return found


def both(result):
    return result["median_ms"], result["cpu_ms"]


def measure(data, frames, rounds, work):
    """For each case ((layersplat's ms, the peer's ms), (CPU ms of both)): medians over rounds that alternate between all programs."""
    times = [([], []) for _ in CASES]
    versions = {}
    for _ in range(rounds):
        for (_, ours, which, theirs), (own, other) in zip(CASES, times):
            own.append(both(bench(data, ours, frames)))
            result = peer(which, data, theirs, frames, work)
            other.append(both(result))
            versions[which] = result.get("version")
    medians = [[[statistics.median(column) for column in zip(*rounds)] for rounds in pair] for pair in times]
    return [tuple(zip(*pair)) for pair in medians], versions


def machine():
    cpu = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    return f"{os.cpu_count()} cores of {cpu}, {platform.system()} {platform.release()}"


def table(sets, results, agreements, versions, device, frames, rounds):
    today = datetime.date.today().isoformat()
    lines = [
        f"Printed by `benches/peers/run` on {today}: {machine()}; layersplat on {device}; VTK {versions['vtk']} "
        f"(fixed-point ray caster, all cores), VolPack {versions['volpack']} (classified volume, one thread). 512², one turn of {frames} "
        f"frames about y at elevation 20°; medians in ms of {rounds} rounds in which all took turns, layersplat : peer, and how many times "
        "faster layersplat is; below, CPU ms of a frame, of all threads.",
        "",
        "| | " + " | ".join(sets) + " | geometric mean |",
        "|---|" + "---|" * (len(sets) + 1),
    ]
    for i, (title, *_) in enumerate(CASES):
        pairs, cpu_pairs = zip(*(results[name][i] for name in sets))
        mean = math.exp(statistics.mean(math.log(b / a) for a, b in pairs))
        cells = [f"{a:.1f} : {b:.1f} = **{b / a:.1f}×**" for a, b in pairs]
        lines.append(f"| {title} | " + " | ".join(cells) + f" | **{mean:.1f}×** |")
        cells = [f"{a:.1f} : {b:.1f}" for a, b in cpu_pairs]
        mean = math.exp(statistics.mean(math.log(b / a) for a, b in cpu_pairs))
        lines.append("| CPU ms | " + " | ".join(cells) + f" | {mean:.1f}× |")
    for which, title in [("vtk", "VTK, step 0.5"), ("volpack", "VolPack")]:
        cells = [f"{agreements[name][which]:.1f} dB" for name in sets]
        lines.append(f"| agreement with {title}, unshaded | " + " | ".join(cells) + " | |")
    return "\n".join(lines)


def write(text):
    page = ROOT / "docs/dev/performance.md"
    begin, end = "<!-- peers -->\n", "\n<!-- /peers -->"
    before, rest = page.read_text().split(begin)
    page.write_text(before + begin + text + end + rest.split(end)[1])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("sets", nargs="*")
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--frames", type=int, default=25)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    sets = options.sets or SETS
    results, agreements, versions, device = {}, {}, {}, None
    for name in sets:
        data = DataSet(name, options.work)
        agreements[name] = agreement(data, options.frames, options.work)
        results[name], versions = measure(data, options.frames, options.rounds, options.work)
        device = bench(data, ["--size", "64x64"], 1)["device"]
        print(name, agreements[name], [f"{b / a:.1f}x" for (a, b), _ in results[name]], file=sys.stderr)
    text = table(sets, results, agreements, versions, device, options.frames, options.rounds)
    print(text)
    if not options.sets:
        write(text)


main()
