"""Time against active samples, viewport and volume, beside VTK where pictures grow with volumes, and the cost of empty space.

growth.py WORK
"""

import json
import pathlib
import subprocess
import sys

import matplotlib
import matplotlib.ticker
import numpy

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = pathlib.Path(sys.argv[1])
LAYERSPLAT = ROOT / "target/release/layersplat"
VTK = ROOT / "benches/peers/vtk_frames.py"
TRANSFER = ROOT / "benches/hydrogen.json"
FRAMES = 25
VIEWPORTS = [256, 512, 1024, 2048]
VOLUMES = [64, 128, 256, 512]
# Volumes with pictures as wide as they are, and the largest of them whose gradients VTK has memory for.
GROWING = ["gyroid", "torus-knot"]
SIDES, VTK_SIDE = [64, 128, 256, 512, 1024], 512
FROM = 256  # the side that the others are compared with
THRESHOLDS = [200, 140, 100, 70, 50, 35, 25, 15, 8, 4, 2]
# Radius of a ball with 0.5 % of the voxels of 512³.
SIDE, RADIUS = 512, 54


def output(command):
    result = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if result.returncode:
        sys.exit(f"{command}\n{result.stderr}")
    return result.stdout


def bench(volume, *options):
    return json.loads(output([LAYERSPLAT, "bench", volume, "--frames", FRAMES, "--json", *options]).splitlines()[-1])


def builtin_file(name, side):
    """A built-in volume as a raw file, which VTK reads too."""
    path = WORK / f"{name}_{side}x{side}x{side}_uint8.raw"
    if not path.exists():
        output([LAYERSPLAT, "convert", f"builtin:{name}@{side}", path])
    return path


def nanoseconds(b):
    """CPU time of an active sample."""
    return 1e6 * b["cpu_ms"] / b["active_samples"]


def growing(name):
    """Rows of a table: a volume with pictures as wide in pixels as it is in voxels."""
    ours, theirs = {}, {}
    for side in SIDES:
        file = builtin_file(name, side)
        ours[side] = bench(file, "--size", f"{side}x{side}", "--transfer", TRANSFER, "--elevation", 20)
        if side <= VTK_SIDE:
            options = ["--size", side, "--frames", FRAMES, "--shaded"]
            theirs[side] = json.loads(output([sys.executable, VTK, file, TRANSFER, *options]).splitlines()[-1])
    rows = []
    for side, b in ours.items():
        vtk = theirs.get(side)
        ratio = f"{vtk['cpu_ms']:.0f} = {vtk['cpu_ms'] / b['cpu_ms']:.1f}×" if vtk else ""
        per_sample = nanoseconds(b)
        rows.append([f"{name}, {side}³", f"{b['active_samples']:,}", f"{b['median_ms']:.1f}", f"{b['cpu_ms']:.1f}", f"{per_sample:.1f}",
                     f"{per_sample / nanoseconds(ours[FROM]):.2f}", ratio])
    return rows


def thin_fog(threshold):
    """Everything above a threshold, so thin that no ray terminates early."""
    path = WORK / f"fog_{threshold}.json"
    points = [0, 0, threshold - 1, 0, threshold, 0.01, 255, 0.01]
    opacities = [n for i in range(0, len(points), 2) for n in (points[i], points[i + 1], 0.5, 0)]
    path.write_text(json.dumps([{"Name": "fog", "RGBPoints": [0, 0.2, 0.4, 1, 255, 1, 0.6, 0.2], "Points": opacities}]))
    return path


def ball(side):
    """A ball at the centre of a cube of voxels, as a raw file."""
    path = WORK / f"ball_{side}x{side}x{side}_uint8.raw"
    if not path.exists():
        x = numpy.arange(side, dtype=numpy.float32) - (side - 1) / 2
        plane = x[:, None] ** 2 + x[None, :] ** 2
        with open(path, "wb") as file:
            for z in x:
                distance = numpy.sqrt(plane + z * z)
                file.write(numpy.clip(64 * (RADIUS + 2 - distance), 0, 255).astype(numpy.uint8).tobytes())
    return path


def row(label, b):
    return [label, f"{b['active_samples']:,}", f"{b['median_ms']:.2f}", f"{b['cpu_ms']:.2f}"]


def table(first, rows, *more):
    head = [first, "active samples", "median ms", "CPU ms", *more]
    return "\n".join("| " + " | ".join(r) + " |" for r in [head, ["---"] * len(head), *rows])


def panel(axis, x, y, title, label, proportional, ticks=None):
    """`proportional`: maps x to the expected upper bound of the time, up to a factor."""
    axis.loglog(x, y, "o-", color="#1f6f8b")
    reference = numpy.array([proportional(v) for v in x], float)
    axis.loglog(x, y[-1] * reference / reference[-1], "--", color="#999999", linewidth=1)
    axis.set_title(title, fontsize=10)
    axis.set_xlabel(label)
    axis.set_ylabel("median ms per frame")
    axis.grid(True, which="major", color="#dddddd")
    if ticks:
        axis.set_xticks(ticks, [str(t) for t in ticks])
        axis.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())


def main():
    fog = [bench("builtin:hydrogen@128", "--transfer", thin_fog(t)) for t in THRESHOLDS]
    pinned = ["--transfer", TRANSFER]
    sizes = [bench("builtin:hydrogen@128", "--size", f"{n}x{n}", *pinned) for n in VIEWPORTS]
    volumes = [bench(f"builtin:hydrogen@{n}", *pinned) for n in VOLUMES]
    box = 2 * (RADIUS + 4)
    scale = ["--parallel-scale", SIDE * 3**0.5 / 2, "--transfer", thin_fog(128)]
    whole, cropped = bench(ball(SIDE), *scale), bench(ball(box), *scale)

    figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), constrained_layout=True)
    times = lambda results: [b["median_ms"] for b in results]  # noqa: E731
    panel(axes[0], [b["active_samples"] for b in fog], times(fog), "active samples, 128³, 512²", "active samples", float)
    panel(axes[1], VIEWPORTS, times(sizes), "viewport, 128³", "pixels per side", lambda n: n**2, VIEWPORTS)
    panel(axes[2], VOLUMES, times(volumes), "volume, 512²", "voxels per side", lambda n: n**3, VOLUMES)
    figure.savefig(ROOT / "docs/dev/images/growth.png", dpi=110)

    text = "\n\n".join(
        [
            f"Printed by `benches/growth/run`; `standard`, shaded, medians of {FRAMES} frames on {whole['device']}. Dashed: proportional to "
            "active samples, pixels, voxels.",
            "![Time against active samples, viewport and volume](images/growth.png)",
            "**Active samples.** Built-in hydrogen, 128³, thin fog above a falling threshold:",
            table("threshold", [row(str(t), b) for t, b in zip(THRESHOLDS, fog)]),
            "**Viewport.** Built-in hydrogen, 128³:",
            table("pixels", [row(f"{n}²", b) for n, b in zip(VIEWPORTS, sizes)]),
            "**Volume.** Built-in hydrogen in 512² pixels:",
            table("voxels", [row(f"{n}³", b) for n, b in zip(VOLUMES, volumes)]),
            "**Volume and picture.** Built-in volumes in pictures as wide in pixels as they are in voxels, one turn at elevation 20°; VTK's "
            "fixed-point ray caster with step 1, shaded, as above:",
            table("volume", [r for name in GROWING for r in growing(name)], "CPU ns per sample", f"of that at {FROM}³", "VTK, CPU ms"),
            f"**Empty space.** A ball that is 0.5 % of 512³ voxels, and the same cropped to its box, at one scale: the whole takes "
            f"{whole['median_ms'] / cropped['median_ms']:.2f} times as long.",
            table("volume", [row(f"{SIDE}³", whole), row(f"{box}³", cropped)]),
        ]
    )
    page = ROOT / "docs/dev/performance.md"
    begin, end = "<!-- growth -->\n", "\n<!-- /growth -->"
    before, rest = page.read_text().split(begin)
    page.write_text(before + begin + text + end + rest.split(end)[1])
    print(text)


main()
