"""Makes the lattice kernel print how long each tile takes: print_tiles.py point_lattice.cl

A line per tile: `tile WORK_ITEM NUMBER COLUMNS CYCLES`, with its number in the picture, row by row, of COLUMNS tiles.
"""

import pathlib
import sys

CLOCK = """static __attribute__((noinline)) ulong cycles(void) {
    __asm__ volatile("" ::: "memory");
    const ulong now = __builtin_readcyclecounter();
    __asm__ volatile("" ::: "memory");
    return now;
}

__kernel void point_lattice("""
EDITS = [
    ("__kernel void point_lattice(", CLOCK),
    ("    const int id = scheduled_tile(&p, order);\n", "    const int id = scheduled_tile(&p, order);\n    const ulong started = cycles();\n"),
    ("    active_samples[id] = total;\n", '    active_samples[id] = total;\n    printf("tile %d %d %d %lu\\n", order, id, p.tiles_u, cycles() - started);\n'),
]


def main(path):
    text = pathlib.Path(path).read_text()
    for old, new in EDITS:
        if text.count(old) != 1:
            sys.exit(f"{path}: {old!r} is there {text.count(old)} times, not once: adapt {__file__}")
        text = text.replace(old, new)
    pathlib.Path(path).write_text(text)


main(sys.argv[1])
