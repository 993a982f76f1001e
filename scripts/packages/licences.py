"""Prints the licences of all crates that a package of the workspace contains: `licences.py PACKAGE TRIPLE`. Identical texts are printed once."""

import json
import pathlib
import subprocess
import sys

#: Beginnings of the names of files that hold licences.
NAMES = ("LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE", "UNLICENSE")


def output(*command):
    return subprocess.run(["cargo", *command], check=True, capture_output=True, text=True).stdout


def linked(package, triple):
    """Names and versions of the crates that a package is linked with."""
    edges = ["--edges", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"]
    lines = output("tree", "--locked", "--package", package, "--target", triple, *edges).splitlines()
    return {(name, version.removeprefix("v")) for name, version, *_ in (line.split() for line in lines if line)}


def texts(package):
    """The licence files of a package."""
    folder = pathlib.Path(package["manifest_path"]).parent
    files = [file for file in sorted(folder.iterdir()) if file.name.upper().startswith(NAMES) and file.is_file()]
    return [file.read_text(errors="replace").strip() for file in files]


def main(name, triple):
    wanted = linked(name, triple)
    metadata = json.loads(output("metadata", "--locked", "--all-features", "--format-version", "1", "--filter-platform", triple))
    # Packages of the workspace have no source.
    packages = [p for p in metadata["packages"] if p["source"] and (p["name"], p["version"]) in wanted]
    users = {}
    print(f"{name} contains these crates:\n")
    for package in packages:
        print(f"    {package['name']} {package['version']}: {package['license'] or package['license_file']}")
        for text in texts(package):
            users.setdefault(text, []).append(package["name"])
    for text, names in users.items():
        print(f"\n{'=' * 100}\nOf {', '.join(dict.fromkeys(names))}:\n\n{text}")


main(*sys.argv[1:])
