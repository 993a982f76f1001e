"""Reports registers, stack, spills and occupancy of each kernel on GPUs, from offline compilers. Started by scripts/gpu-static.

NVIDIA: clang with libclc generates PTX, from which ptxas generates code. The driver uses another compiler before ptxas, so its figures are
similar but not equal. AMD: clang with libclc generates code, like AMD's driver, which uses another library. Intel: there are no figures,
because ocloc is in neither Debian 12 nor PyPI.

Occupancy is the maximum number of resident waves relative to the capacity of a compute unit:
    waves per SIMD   = min(limit, registers per lane / registers of the kernel, rounded up to the allocation granularity)
    groups           = min(SIMDs x waves per SIMD / waves per group, group limit, local memory / that of the kernel), all rounded down
    occupancy        = groups x waves per group / (SIMDs x wave limit)
Stack is in bytes per work-item, local memory in bytes per work-group (AMD's compiler moves arrays there, for groups of up to 256). Spills to
memory are bytes on NVIDIA and registers on AMD, which keeps further scalars in lanes of vector registers. A star marks kernels of the default
render paths, with their quality presets. A kernel in a file of another name is shown as file:kernel.
"""

import argparse
import glob
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from gpu_static_instructions import counted

# Limits of --check: no kernel may have a stack, except one that lists the visible voxels for sheets, and those of several fields, of colours
# and of labels, in which a work-item draws a tile. Kernels of the default render path (the warp also to 8 bits) have a register limit.
CHECKED = ["sm_90", "gfx1100"]
WITH_STACK = ["splats", "channel_lattice", "channel_raycast", "color_lattice", "color_raycast", "label_moments"]
DEFAULT_PATH = ["point_samples", "warp"]
MOST_REGISTERS = {"standard": 96, "high": 128}
# Subdivided segments read the field between samples. They need more registers, and scalars that AMD's compiler keeps in lanes.
DIMMED = {"registers": 128, "lanes": 8}
# The indices of the eight labels around a point.
TINTED = {"stack": 32}


class Unit(NamedTuple):
    """Resources of a compute unit. NVIDIA: CUDA C++ Programming Guide, technical specifications; AMD: LLVM's AMDGPUBaseInfo.cpp."""

    simds: int
    lanes: int
    # Registers per lane of a SIMD, and allocation granularity per wave.
    registers: int
    portion: int
    # Largest number of waves per SIMD, of groups with several waves, and of groups with one wave.
    waves: int
    groups: int
    single: int
    local: int
    # Scalar registers per SIMD, if they limit its waves.
    scalars: int | None = None


ARCHITECTURES = {
    "sm_80": Unit(4, 32, registers=512, portion=8, waves=16, groups=32, single=32, local=164 << 10),
    "sm_90": Unit(4, 32, registers=512, portion=8, waves=16, groups=32, single=32, local=228 << 10),
    "gfx90a": Unit(4, 64, registers=512, portion=8, waves=8, groups=16, single=32, local=64 << 10, scalars=800),
    # A pair of compute units, which a group shares.
    "gfx1100": Unit(4, 32, registers=1536, portion=24, waves=16, groups=32, single=64, local=128 << 10),
}

# As OpenCL permits and NVIDIA's compiler does: division to 2.5 ulp, square root to 3 ulp, denormals flushed to zero.
OPTIONS_OF_NVPTX = "-mllvm -nvptx-prec-divf32=1 -mllvm -nvptx-prec-sqrtf32=0 -Xclang -fdenormal-fp-math-f32=preserve-sign,preserve-sign"
COMMON_OPTIONS = "-x cl -Xclang -finclude-default-header -O3 -Wno-linker-warnings -Wno-unused-command-line-argument -S"


def run(*command):
    """Standard output and standard error of a command. Raises an error with its standard error if it fails."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{shlex.join(command)}\n{done.stderr}")
    return done.stdout + done.stderr


def clang(arguments, options, target, library, text, folder):
    """Compiles a program; returns the path of its assembly."""
    source, assembly = os.path.join(folder, "program.cl"), os.path.join(folder, "program.s")
    with open(source, "w", encoding="utf-8") as file:
        file.write(text)
    linked = f"-Xclang -mlink-builtin-bitcode -Xclang /usr/lib/clc/{library}.bc"
    run(arguments.clang, *shlex.split(f"{COMMON_OPTIONS} {options} {target} {linked}"), "-o", assembly, source)
    return assembly


def tool(arguments, name):
    """Path of a program of an NVIDIA package from PyPI."""
    return glob.glob(f"{arguments.nvidia}/lib/python3*/site-packages/nvidia/*/bin/{name}")[0]


def numbers(pattern, text):
    return [int(number) for number in re.findall(pattern, text, re.MULTILINE)]


def nvidia(arguments, architecture, options, text, folder):
    """Figures by kernel, for NVIDIA."""
    target = f"-target nvptx64-nvidia-nvcl -Xclang -target-cpu -Xclang {architecture} {OPTIONS_OF_NVPTX}"
    ptx = clang(arguments, options, target, "nvptx64--nvidiacl", text, folder)
    code = ptx + ".cubin"
    output = run(tool(arguments, "ptxas"), "-v", "-arch", architecture, "-o", code, ptx)
    instructions = counted("nvidia", run(tool(arguments, "nvdisasm"), "-c", code)) if arguments.json else {}
    found = {}
    for part in output.split("Compiling entry function ")[1:]:
        name = part.split("'")[1]
        found[name] = {
            "registers": sum(numbers(r"Used (\d+) registers", part)),
            # The cumulative figure includes called functions.
            "stack": max(numbers(r"(\d+) bytes (?:stack frame|cumulative stack size)", part), default=0),
            "spills": sum(numbers(r"(\d+) bytes spill", part)),
            "lanes": 0,
            "local": sum(numbers(r"(\d+) bytes smem", part)),
            "instructions": instructions.get(name, {}),
        }
    return found


def amd(arguments, architecture, options, text, folder):
    """Figures by kernel, for AMD."""
    target = f"-target amdgcn-amd-amdhsa -mcpu={architecture} -nogpulib"
    with open(clang(arguments, options, target, "amdgcn--amdhsa", text, folder), encoding="utf-8") as file:
        assembly = file.read()
    instructions = counted("amd", assembly) if arguments.json else {}
    found = {}
    for part in re.split(r"^  - (?=\.)", assembly.split(".amdgpu_metadata")[1], flags=re.MULTILINE)[1:]:
        fields = dict(re.findall(r"^(?:    )?\.(\w+): +(\S+)", part, re.MULTILINE))
        name = fields["name"]
        found[name] = {
            "registers": int(fields["vgpr_count"]),
            "scalars": int(fields["sgpr_count"]),
            "stack": int(fields["private_segment_fixed_size"]),
            "spills": int(fields["vgpr_spill_count"]),
            # Scalars that lanes of vector registers hold.
            "lanes": int(fields["sgpr_spill_count"]),
            "local": int(fields["group_segment_fixed_size"]),
            "instructions": instructions.get(name, {}),
        }
    return found


def occupancy(architecture, kernel, group):
    """Occupancy of a kernel on a unit."""
    unit = ARCHITECTURES[architecture]
    registers = -(-max(kernel["registers"], 1) // unit.portion) * unit.portion
    waves = min(unit.waves, unit.registers // registers)
    if unit.scalars:
        waves = min(waves, unit.scalars // max(kernel["scalars"], 1))
    waves_of_group = -(-group // unit.lanes)
    groups = min(unit.simds * waves // waves_of_group, unit.single if waves_of_group == 1 else unit.groups)
    if kernel["local"]:
        groups = min(groups, unit.local // kernel["local"])
    return groups * waves_of_group / (unit.simds * unit.waves)


def compiled(arguments, architecture, options, text):
    with tempfile.TemporaryDirectory() as folder:
        return (nvidia if architecture.startswith("sm_") else amd)(arguments, architecture, options, text, folder)


def measured(arguments, kernels):
    """Rows by kernel, options and architecture. Programs with several kernels or equal source are compiled once."""
    programs = sorted({(a, k["options"], k["source"]) for k in kernels for a in arguments.arch})
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        results = dict(zip(programs, pool.map(lambda program: compiled(arguments, *program), programs)))
    rows = []
    for kernel in kernels:
        for architecture in arguments.arch:
            figures = results[architecture, kernel["options"], kernel["source"]][kernel["kernel"]]
            known = {name: kernel[name] for name in ("name", "kernel", "file", "options", "group", "qualities")}
            share = occupancy(architecture, figures, kernel["group"])
            rows.append({**known, "arch": architecture, **figures, "occupancy": share})
    return rows


def edited(kernels, edits):
    """A copy of the kernels for each named edit. An edit is a list of pairs: a text and its replacement."""
    copies = []
    for name, pairs in edits.items():
        for kernel in kernels:
            text = kernel["source"]
            for old, new in pairs:
                if old not in text:
                    raise RuntimeError(f"edit {name} of {kernel['name']}: its source has no {old!r}; adapt the edit to the kernel")
                text = text.replace(old, new)
            copies.append({**kernel, "name": f"{kernel['name']}, {name}", "source": text})
    return copies


def defines(row):
    """The macro definitions of a program's build options."""
    return " ".join(option.removeprefix("-D") for option in row["options"].split() if option.startswith("-D"))


def print_table(rows):
    print(f"{'':10}{'registers':>10}{'stack':>8}{'spills':>8}{'lanes':>8}{'local':>8}{'occupancy':>11}")
    before = None
    for row in rows:
        star = f" * {', '.join(row['qualities'])}" if row["qualities"] else ""
        about = f"{row['name']}{star}, groups of {row['group']}: {defines(row)}"
        if about != before:
            print(about)
        before = about
        print(f"  {row['arch']:8}{row['registers']:10}{row['stack']:8}{row['spills']:8}{row['lanes']:8}{row['local']:8}{row['occupancy']:11.0%}")


def check(rows, wanted):
    """Descriptions of exceeded limits."""
    started = {row["kernel"] for row in rows if row["qualities"]}
    wrong = [f"{kernel}: not started by default" for kernel in DEFAULT_PATH if kernel not in started and kernel in (wanted or {kernel})]
    for row in rows:
        limits = {} if row["kernel"] in WITH_STACK else dict(TINTED) if "TINTED" in defines(row).split() else {"stack": 0}
        if row["kernel"] in DEFAULT_PATH and row["qualities"]:
            limits |= {"registers": min(MOST_REGISTERS[quality] for quality in row["qualities"]), "spills": 0, "lanes": 0}
            if "DIMMED" in defines(row).split():
                limits |= DIMMED
        over = [f"{row[name]} {name}, not {most}" for name, most in limits.items() if row[name] > most]
        if over:
            wrong.append(f"{row['name']} ({defines(row)}) on {row['arch']}: {'; '.join(over)}")
    return wrong


def arguments_given():
    as_it_is = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("scripts/gpu-static", description=__doc__, formatter_class=as_it_is)
    parser.add_argument("--json", action="store_true", help="print JSON, with static instruction counts by kind")
    parser.add_argument("--arch", help=f"comma-separated list of {','.join(ARCHITECTURES)} [default: all; with --check {','.join(CHECKED)}]")
    parser.add_argument("--default", action="store_true", help="only kernels of the default render paths, by the qualities standard and high")
    parser.add_argument("--edits", metavar="FILE", help="compile the kernels with edited source; JSON of the form {name: [[text, replacement], …], …}")
    checked = f"fail if a kernel has a stack, or one of the default path spills or needs more registers than {MOST_REGISTERS}; with DIMMED {DIMMED}"
    parser.add_argument("--check", action="store_true", help=checked)
    parser.add_argument("kernels", nargs="*", metavar="KERNEL", help="only these kernels [default: all]")
    for name in ("--clang", "--nvidia", "--programs"):
        parser.add_argument(name, required=True, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    usual = CHECKED if arguments.check else list(ARCHITECTURES)
    arguments.arch = arguments.arch.split(",") if arguments.arch else usual
    unknown = set(arguments.arch) - set(ARCHITECTURES)
    if unknown:
        parser.error(f"unknown architecture {', '.join(sorted(unknown))}; use {', '.join(ARCHITECTURES)}")
    return parser, arguments


def main():
    parser, arguments = arguments_given()
    with open(arguments.programs, encoding="utf-8") as file:
        programs = json.load(file)
    kernels, wanted = programs["kernels"], set(arguments.kernels)
    for kernel in kernels:
        stem = os.path.splitext(os.path.basename(kernel["file"]))[0]
        kernel["name"] = kernel["kernel"] if kernel["kernel"] == stem else f"{stem}:{kernel['kernel']}"
    known = {kernel[by] for kernel in kernels for by in ("name", "kernel")} | set(programs["others"])
    if wanted - known:
        parser.error(f"unknown kernel {', '.join(sorted(wanted - known))}; use {', '.join(sorted(known))}")
    if wanted:
        kernels = [kernel for kernel in kernels if {kernel["name"], kernel["kernel"]} & wanted]
    if arguments.default:
        kernels = [kernel for kernel in kernels if kernel["qualities"]]
    if arguments.edits:
        with open(arguments.edits, encoding="utf-8") as file:
            kernels = edited(kernels, json.load(file))
    rows = measured(arguments, kernels)
    if arguments.json:
        json.dump(rows, sys.stdout, indent=1)
        print()
    else:
        print_table(rows)
        if programs["others"]:
            print(f"Not used on GPUs: {', '.join(programs['others'])}")
    wrong = check(rows, wanted) if arguments.check else []
    print(*wrong, sep="\n", end="\n" if wrong else "", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except RuntimeError as failure:
        sys.exit(str(failure))
