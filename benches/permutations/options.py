"""What each option of the point-sampled layers' programs costs if it is always compiled in: options.py BINARY [OPTION ...]

PoCL adds POCL_EXTRA_BUILD_FLAGS to the options of every program. Frames of each data set are drawn by the specialised program and by the
same program with one more option, by turns. Prints the ratio of CPU times per frame (median of the ratios of all rounds), and the ratio of
the CPU times of a first picture with an empty kernel cache, which is mostly compilation. DIMMED also divides deep segments; the other
options change no picture.
"""

import json
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile

ROUNDS = 7
VOLUMES = pathlib.Path(os.environ.get("LAYERSPLAT_VOLUMES", "../shared/volumes"))
SETS = {"engine": "engine_256x256x128_uint8", "aneurism": "aneurism_256x256x256_uint8", "fuel": "fuel_64x64x64_uint8"}
# Frames per round, so that a round takes about half a CPU second.
FRAMES = {"engine": 49, "aneurism": 121, "fuel": 361}
OPTIONS = {
    "nothing": "", "DIMMED": "-DDIMMED", "CLIPPED": "-DCLIPPED", "THINNED": "-DTHINNED", "SEVERAL_LIGHTS": "-DSEVERAL_LIGHTS",
    "DEPTH_CUED": "-DDEPTH_CUED",
}


def bench(binary, name, flags, cache, frames):
    """CPU milliseconds per frame, and CPU seconds of the process."""
    transfer = VOLUMES.parent / "transfer" / f"{name}.json"
    command = [binary, "bench", VOLUMES / f"{SETS[name]}.raw.gz", "--transfer", transfer, "--size", "512x512", "--frames", str(frames)]
    environment = {**os.environ, "POCL_EXTRA_BUILD_FLAGS": flags, "POCL_CACHE_DIR": cache}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([*command, "--device-unchecked", "--json"], env=environment, capture_output=True, text=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return json.loads(done.stdout)["cpu_ms"], after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main(binary, options):
    print("option                 " + "".join(f"{name:>10}" for name in SETS) + "  first picture")
    with tempfile.TemporaryDirectory() as folder:
        cache = lambda option: str(pathlib.Path(folder, option))
        first = {}
        for option in ["specialised", *options]:
            os.mkdir(cache(option))
            first[option] = bench(binary, "engine", OPTIONS.get(option, ""), cache(option), 1)[1]
        for option in options:
            told = ""
            for name in SETS:
                ratios = []
                for _ in range(ROUNDS):
                    one, other = (bench(binary, name, OPTIONS.get(o, ""), cache(o), FRAMES[name])[0] for o in ("specialised", option))
                    ratios.append(other / one)
                told += f"{statistics.median(ratios):10.3f}"
            print(f"{option:23}{told}{first[option] / first['specialised']:15.2f}", flush=True)


main(sys.argv[1], sys.argv[2:] or list(OPTIONS))
