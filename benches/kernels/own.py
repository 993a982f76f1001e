"""Every kernel and quality against its kernel's own integral, lit: ray casting in steps of 1/16. own.py [KERNEL...]"""

import pathlib
import sys
import tempfile

from scenes import ANEURISM, CONVERGED, ENGINE, FITTED, NEGHIP, SKULL, WAYS, kernel_options, psnr, run, table

KERNELS = sys.argv[1:] or ["cubic", "catmull-rom", "bspline"]
VIEWS = {"engine": [*ENGINE, *FITTED], "aneurism": [*ANEURISM, *FITTED], "neghip": [*NEGHIP, *FITTED],
         "skull": [*SKULL, "--parallel-scale", 70]}


def main():
    rows = {(kernel, way): [] for kernel in KERNELS for way in WAYS}
    with tempfile.TemporaryDirectory() as folder:
        truth, found = (pathlib.Path(folder) / f"{name}.npy" for name in ("truth", "found"))
        for kernel in KERNELS:
            for view in VIEWS.values():
                run("render", *view, *kernel_options(kernel), *CONVERGED, "--output", truth)
                for way, options in WAYS.items():
                    run("render", *view, *kernel_options(kernel), *options, "--output", found)
                    rows[kernel, way].append(f"{psnr(found, truth):.1f}")
    print(table(["", "lit", *VIEWS], [[*names, *row] for names, row in rows.items()]))


main()
