"""pyopencl's wheel contains its own OpenCL loader. Handles are interchangeable if both loaders find the same implementation."""

import ctypes
import os
import pathlib
import shutil
import subprocess
import sys

import pyopencl as cl
import pytest

import layersplat
from host import Host
from layersplat import _loader


def mapped(word):
    """Files with `word` in their name that this process has mapped."""
    lines = pathlib.Path("/proc/self/maps").read_text().splitlines()
    return {line.split(maxsplit=5)[5] for line in lines if line.count(" ") >= 5 and word in line.rsplit("/", 1)[-1]}


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc/self/maps")
def test_there_are_two_loaders_and_one_implementation():
    Host().device()
    assert len(mapped("libOpenCL")) == 2, mapped("libOpenCL")
    if "Portable Computing Language" in layersplat.Device.list()[0]["platform"]:
        assert len(mapped("libpocl.so")) == 1, mapped("libpocl")


def test_both_loaders_name_the_same_objects():
    ours = layersplat.Device()
    theirs = {device.int_ptr: device for platform in cl.get_platforms() for device in platform.get_devices()}
    assert ours.id in theirs
    context = cl.Context.from_int_ptr(ours.context, retain=True)
    assert context.devices == [theirs[ours.id]]
    queue = cl.CommandQueue.from_int_ptr(ours.queue, retain=True)
    assert layersplat.Device(queue=queue).context == ours.context


ASKED = """
import sys
def asked(call):
    try:
        return len(call())
    except Exception as error:
        return type(error).__name__
import layersplat, pyopencl
print(asked(layersplat.Device.list), asked(pyopencl.get_platforms))
"""


def answers(vendors):
    environment = {**os.environ, "OCL_ICD_VENDORS": str(vendors)}
    environment.pop("OCL_ICD_FILENAMES", None)
    run = subprocess.run([sys.executable, "-c", ASKED], env=environment, capture_output=True, text=True, timeout=120, check=True)
    return run.stdout.split()


def test_both_follow_the_environment_variable(tmp_path):
    found = layersplat.Device.list()
    vendors = pathlib.Path(os.environ.get("OCL_ICD_VENDORS", "/etc/OpenCL/vendors"))
    if not vendors.is_dir():
        pytest.skip(f"no folder of implementations, {vendors}")
    assert answers(vendors) == [str(len(found)), str(len(cl.get_platforms()))]
    assert answers(tmp_path) == ["DeviceError", "LogicError"] or answers(tmp_path) == ["DeviceError", "0"]


ONE = """
import pathlib, sys
import layersplat, pyopencl
assert layersplat.Device.list() and pyopencl.get_platforms()
maps = pathlib.Path("/proc/self/maps").read_text().splitlines()
print(len({line.split()[-1] for line in maps if "libOpenCL" in line}))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc/self/maps")
def test_layersplat_takes_another_loader():
    """For example that of pyopencl, which is sufficient if the system has none."""
    for theirs in mapped("libOpenCL"):
        environment = {**os.environ, "OPENCL_DYLIB_PATH": theirs}
        run = subprocess.run([sys.executable, "-c", ONE], env=environment, capture_output=True, text=True, timeout=120, check=True)
        assert run.stdout.split() == ["1" if "pyopencl" in theirs else "2"]


ALONE = """
import os, sys
import layersplat
if len(sys.argv) > 1:
    os.environ["OPENCL_DYLIB_PATH"] = sys.argv[1]
print(len(layersplat.Device.list()), "pyopencl" in sys.modules, os.environ.get("PYOPENCL_HOME"))
print(next(line.split()[-1] for line in open("/proc/self/maps") if "libOpenCL" in line))
"""


def alone(*arguments, **variables):
    """The output of a process without pyopencl."""
    environment = {**os.environ, **variables}
    environment.pop("PYOPENCL_HOME", None)
    run = subprocess.run([sys.executable, "-c", ALONE, *arguments], env=environment, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, (run.returncode, run.stderr)
    return [line.split() for line in run.stdout.splitlines()]


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc/self/maps")
def test_the_loader_of_pyopencls_wheel_works_without_pyopencl(tmp_path):
    """The loader reads PYOPENCL_HOME without checking that it is set."""
    count, home = str(len(layersplat.Device.list())), str(pathlib.Path(cl.__file__).parent)
    (theirs,) = [path for path in mapped("libOpenCL") if "pyopencl" in path]
    expected = [[count, "False", home], [theirs]]
    assert alone(OPENCL_DYLIB_PATH=theirs) == expected
    assert alone(OPENCL_DYLIB_PATH=f"/nonexistent.so;{theirs}") == expected
    assert alone(theirs) == expected, "set after the import"
    copied = shutil.copy(theirs, tmp_path)
    assert alone(OPENCL_DYLIB_PATH=copied) == [[count, "False", str(tmp_path)], [copied]]


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc/self/maps")
def test_other_loaders_leave_the_environment_alone():
    layersplat.Device.list()
    (system,) = [path for path in mapped("libOpenCL") if "pyopencl" not in path]
    for named in (system, "libOpenCL.so.1"):
        assert alone(OPENCL_DYLIB_PATH=named)[0][1:] == ["False", "None"]


@pytest.fixture
def machine(monkeypatch, tmp_path):
    """A made-up machine whose wheel has a loader of its own: a function of what else is there. It returns the variables that are set."""
    own, registered_in, packages = tmp_path / "_opencl" / "libOpenCL.so.1", tmp_path / "vendors", tmp_path / "packages"
    for folder in (own.parent, registered_in, packages / "pocl_binary_distribution", packages / "pyopencl" / ".libs"):
        folder.mkdir(parents=True)
    own.write_bytes(b"asks for PYOPENCL_HOME")
    (packages / "pocl_binary_distribution" / "__init__.py").write_text("")
    (packages / "pyopencl" / ".libs" / "pocl.icd").write_text("libpocl.so")
    (packages / "pyopencl" / ".libs" / "libpocl.so").write_bytes(b"")
    (packages / "zig").write_bytes(b"")
    monkeypatch.setattr(_loader, "OWN", own)
    monkeypatch.setattr(_loader, "REGISTERED", registered_in)
    monkeypatch.setattr(_loader, "ZIG", packages / "zig")

    def variables(*libraries, registered=(), installed=False, programs=(), **environment):
        def load(name):
            if name not in libraries:
                raise OSError(name)

        for number, library in enumerate(registered):
            (registered_in / f"{number}.icd").write_text(library + "\n")
        if installed:
            monkeypatch.syspath_prepend(str(packages))
        monkeypatch.setattr(ctypes, "CDLL", load)
        monkeypatch.setattr(shutil, "which", lambda name: name if name in programs else None)
        monkeypatch.setattr(os, "environ", dict(environment))
        _loader.prepare()
        return {name: value for name, value in os.environ.items() if environment.get(name) != value}

    return variables


SYSTEM, GPU = "libOpenCL.so.1", "libgpu.so"


def own_loader(folder):
    return {"OPENCL_DYLIB_PATH": str(folder / "_opencl" / "libOpenCL.so.1"), "PYOPENCL_HOME": str(folder / "_opencl")}


def test_a_system_with_opencl_is_left_alone(machine):
    assert machine(SYSTEM, GPU, registered=[GPU]) == {}


def test_a_system_with_opencl_is_preferred_to_an_installed_implementation(machine):
    assert machine(SYSTEM, GPU, registered=["libremoved.so", GPU], installed=True) == {}


def test_a_system_without_an_implementation_is_left_alone_if_none_is_installed(machine):
    assert machine(SYSTEM) == {}


@pytest.mark.parametrize("installed", [False, True])
def test_a_system_without_a_loader_gets_the_wheels(machine, tmp_path, installed):
    assert machine(GPU, registered=[GPU], installed=installed) == own_loader(tmp_path)


@pytest.mark.parametrize("registered", [(), ["libremoved.so"]])
@pytest.mark.parametrize("libraries", [(), (SYSTEM,)])
def test_an_installed_implementation_is_found_if_there_is_no_other(machine, tmp_path, libraries, registered):
    library = tmp_path / "packages" / "pyopencl" / ".libs" / "libpocl.so"
    expected = {**own_loader(tmp_path), "OCL_ICD_VENDORS": str(library)}
    assert machine(*libraries, registered=registered, installed=True, programs=["cc", "ld"]) == expected
    assert machine(*libraries, installed=True) == {**expected, "COMPILER_PATH": expected["PYOPENCL_HOME"]}
    assert machine(*libraries, installed=True, COMPILER_PATH="/mine") == expected


def test_an_installed_implementation_that_cannot_link_is_not_used(machine, tmp_path):
    """It would end the process."""
    _loader.ZIG.unlink()
    assert machine(installed=True) == own_loader(tmp_path)


def test_variables_of_the_user_are_left_alone(machine):
    assert machine(PYOPENCL_HOME="/home").keys() == {"OPENCL_DYLIB_PATH"}
    assert machine(OPENCL_DYLIB_PATH="/loader.so") == {}
    assert machine(SYSTEM, installed=True, OCL_ICD_VENDORS="/vendors") == {}
