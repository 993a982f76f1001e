"""Renders a list of pictures with two binaries and compares them bit for bit: pictures.py BEFORE AFTER

Prints each differing picture with its largest difference. Exit code 1 if one differs, or if only one binary renders it.
"""

import array
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

TYPES = {"uint8": "B", "int8": "b", "uint16": "H", "int16": "h", "float32": "f", "float64": "d"}
RANGES = {"uint8": (0, 255), "int8": (-90, 120), "uint16": (0, 40000), "int16": (-1000, 3000), "float32": (-2.5, 7.25), "float64": (0, 1e4)}


def write_volume(folder, kind, dims, seed):
    """A noisy off-centre ball of a voxel type."""
    chance = random.Random(seed)
    low, high = RANGES[kind]
    values = array.array(TYPES[kind])
    nx, ny, nz = dims
    for k in range(nz):
        for j in range(ny):
            for i in range(nx):
                p = [(2 * i + 1) / nx - 1.1, (2 * j + 1) / ny - 0.9, (2 * k + 1) / nz - 1.05]
                share = min(max(1.2 - math.hypot(*p) + 0.25 * chance.random(), 0), 1)
                value = low + share * (high - low)
                values.append(value if kind.startswith("float") else int(value))
    path = folder / f"ball_{nx}x{ny}x{nz}_{kind}.raw"
    path.write_bytes(values.tobytes())
    return str(path)


def write_preset(folder, name, points, opacities):
    preset = {"Name": name, "ColorSpace": "RGB", "RGBPoints": points, "Points": opacities}
    path = folder / f"{name}.json"
    path.write_text(json.dumps([preset]))
    return str(path)


def pictures(folder):
    """Names and arguments."""
    volumes = {kind: write_volume(folder, kind, dims, seed) for seed, (kind, dims) in enumerate({
        "uint8": (61, 47, 53), "int8": (33, 40, 29), "uint16": (40, 37, 45), "int16": (57, 31, 42), "float32": (35, 50, 41), "float64": (31, 34, 37)}.items())}
    hues = write_preset(folder, "hues", [0, 1, 0, 0, 60, 0, 1, 0, 120, 0, 0, 1, 180, 1, 1, 0, 255, 1, 0, 1],
                        [0, 0, 0.5, 0, 30, 0.1, 0.5, 0, 120, 0.95, 0.5, 0, 255, 0.99, 0.5, 0])
    narrow = write_preset(folder, "narrow", [100, 1, 0.5, 0, 140, 0, 0.5, 1], [100, 0, 0.5, 0, 120, 0.4, 0.5, 0, 140, 0, 0.5, 0])
    background = write_preset(folder, "background", [0, 0.2, 0.4, 0.9, 255, 1, 1, 0.5], [0, 0.02, 0.5, 0, 128, 0, 0.5, 0, 255, 0.5, 0.5, 0])
    ball, hydrogen = volumes["uint8"], "builtin:hydrogen@48"
    view = ["--azimuth", "31", "--elevation", "17", "--roll", "8"]
    perspective = [*view, "--perspective", "35"]
    inside = ["--perspective", "75", "--distance", "4", "--azimuth", "20"]
    algorithms = {
        "draft": ["--quality", "draft"], "standard": [], "high": ["--quality", "high"], "paper": ["--quality", "paper"],
        "post": ["--classification", "post"], "direct": ["--lattice", "direct"], "post-direct": ["--classification", "post", "--lattice", "direct"],
        "constant": ["--correction", "constant"], "fixed3": ["--lattice", "3", "--sublayers", "3"],
        "axis-sheets": ["--algorithm", "axis-sheets"], "view-sheets": ["--algorithm", "view-sheets", "--sheet-distance", "0.7"],
        "slicing": ["--algorithm", "slicing", "--step", "0.8"], "raycast": ["--algorithm", "raycast"],
        "tricubic": ["--algorithm", "raycast", "--kernel", "cubic"], "gaussian": ["--algorithm", "raycast", "--kernel", "gaussian"],
    }
    out = []

    def add(name, volume, *options):
        out.append((name, [volume, *options]))

    for name, options in algorithms.items():
        add(f"{name}", ball, *view, *options, "--size", "97x83")
        if name != "paper":
            add(f"{name}-perspective", ball, *perspective, *options, "--size", "83x101")
    for kind, volume in volumes.items():
        add(f"{kind}", volume, *view, "--size", "64x64")
        add(f"{kind}-post", volume, "--azimuth", "80", "--classification", "post", "--size", "65x63")
        add(f"{kind}-raycast", volume, *perspective, "--algorithm", "raycast", "--size", "63x65")
    for name, options in {"post": ["--classification", "post"], "standard": [], "slicing": ["--algorithm", "slicing"],
                          "raycast": ["--algorithm", "raycast"], "view-sheets": ["--algorithm", "view-sheets"]}.items():
        add(f"background-{name}", ball, "--transfer", background, *view, *options, "--size", "70x70")
        add(f"narrow-{name}", ball, "--transfer", narrow, *view, *options, "--size", "70x70")
        add(f"unlit-{name}", hydrogen, "--shading", "off", *view, *options, "--size", "77x51")
        add(f"linear-{name}", hydrogen, "--extinction", "linear", *view, *options, "--size", "51x77")
        add(f"inside-{name}", ball, *inside, *options, "--size", "60x60")
    for axis in "xyz":
        add(f"axis-{axis}", ball, "--azimuth", "40", "--elevation", "30", "--layer-axis", axis, "--size", "66x66")
        add(f"axis-{axis}-post", ball, "--azimuth", "40", "--elevation", "30", "--layer-axis", axis, "--classification", "post", "--size", "66x66")
    add("hues", ball, "--transfer", hues, *view, "--size", "90x90")
    add("hues-perspective", ball, "--transfer", hues, *perspective, "--quality", "high", "--size", "90x90")
    add("shared-45", ball, "--azimuth", "45", "--elevation", "10", "--size", "80x80")
    add("spacing", ball, "--spacing", "2.5,0.5,0.5", "--azimuth", "50", "--size", "80x80")
    add("unit-distance", ball, "--unit-distance", "3", *view, "--size", "80x80")
    add("never-opaque", ball, "--early-termination", "off", *view, "--size", "80x80")
    add("magnified", ball, "--parallel-scale", "4", *view, "--size", "120x90")
    add("small", ball, *view, "--size", "9x7")
    add("one-pixel", ball, "--azimuth", "0", "--size", "1x1")
    add("thin", "builtin:hydrogen@1x30x30", *view, "--size", "64x64")
    add("thin-post", "builtin:hydrogen@30x1x30", *view, "--classification", "post", "--size", "64x64")
    add("cube", "builtin:cube@24", "--perspective", "40", "--azimuth", "10", "--size", "71x73")
    return out


def render(binary, arguments, path):
    path.unlink(missing_ok=True)
    done = subprocess.run([binary, "render", *arguments, "-o", str(path)], capture_output=True, text=True)
    return None if done.returncode else path.read_bytes()


def largest_difference(one, other):
    """Largest difference of two .npy files of float32 with the same shape."""
    if len(one) != len(other):
        return math.inf
    floats = [array.array("f", data[10 + int.from_bytes(data[8:10], "little"):]) for data in (one, other)]
    return max(abs(a - b) for a, b in zip(*floats))


def main():
    before, after = sys.argv[1:3]
    different, worst = 0, 0.0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        wanted = pictures(folder)
        for name, arguments in wanted:
            extension = "png" if name.startswith("background") else "npy"
            # One name for both, since the command line stands in a PNG.
            one, other = (render(binary, arguments, folder / f"picture.{extension}") for binary in (before, after))
            if one == other and one is not None:
                continue
            different += 1
            if one is None or other is None:
                print(f"{name}: {'both refuse' if one == other else 'one refuses'}: {' '.join(arguments)}")
            elif extension == "npy":
                largest = largest_difference(one, other)
                worst = max(worst, largest)
                print(f"{name}: largest difference {largest:.2g}")
            else:
                print(f"{name}: the bytes differ")
    print(f"{len(wanted)} pictures, {different} differ, by at most {worst:.2g}")
    sys.exit(different > 0)


main()
