"""Exceptions, and that stubs tell the truth."""

import ast
import inspect
import pathlib

import numpy as np
import pytest

import layersplat

PLACE = {"azimuth": 0.0}


def test_the_classes_are_pythons_own_too():
    own = [layersplat.InvalidValue, layersplat.DeviceError, layersplat.OutOfMemory, layersplat.FileError]
    for ours, pythons in zip(own, [ValueError, RuntimeError, MemoryError, OSError]):
        assert issubclass(ours, pythons) and issubclass(ours, layersplat.Error)


@pytest.mark.parametrize(
    "given, field, words",
    [
        ({"quality": "best"}, "quality", "use draft, standard, high or paper"),
        ({"algorithm": "magic"}, "algorithm", "use layered"),
        ({"blend": "sum"}, "blend", "composite, maximum"),
        ({"blend": "iso"}, "blend", "give \\('iso', value\\)"),
        ({"blend": ("maximum", 3.0)}, "blend", "takes no value"),
        ({"kernel": "sinc"}, "kernel", "use cubic"),
        ({"step": 0.5}, "step", "no meaning for layered"),
        ({"algorithm": "raycast", "quality": "high"}, "quality", "no meaning for raycast"),
        ({"algorithm": "slicing", "density": 3}, "density", "no meaning for slicing"),
        ({"quality": "paper", "density": 3}, "density", "no lattice"),
        ({"quality": "paper", "kernel": "cubic"}, "kernel", "the paper's own"),
        ({"shading": {"shine": 1.0}}, "shading", "use ambient"),
        ({"planes": [((0, 0, 0), (1, 0, 0))] * 7}, "clipping", "more than 6"),
        ({"extinction": "cubic"}, "extinction", "exponential or linear"),
        ({"layer_axis": "w"}, "layer_axis", "use auto"),
    ],
)
def test_settings(given, field, words):
    with pytest.raises(layersplat.InvalidValue, match=words) as caught:
        layersplat.Settings(**given)
    assert caught.value.fields == (field,)


def test_pictures(array, transfer):
    renderer = layersplat.Renderer(array, transfer)
    camera = renderer.camera(10)
    for call, words in [
        (lambda: renderer.render(camera, (0, 4)), "1 to 16384 pixels"),
        (lambda: renderer.render(camera, 10, background="pink"), "background 'pink'"),
        (lambda: renderer.render(camera, 10, background=(2, 0, 0)), "from 0 to 1"),
        (lambda: renderer.render(camera, 10, layersplat.Settings(unit_distance=-1)), "unit_distance"),
        (lambda: renderer.camera(10, zoom=0), "zoom"),
        (lambda: renderer.camera(10, field_of_view=180), "between 0 and 180"),
        (lambda: layersplat.Camera((0, 0, 1), (0, 0, 0)), "either scale"),
        (lambda: layersplat.Camera((0, 0, 0), (0, 0, 0), scale=1), "coincide"),
        (lambda: layersplat.Device("no such device"), "unknown device"),
        (lambda: layersplat.volshow(array, blend="maximum", settings=layersplat.Settings()), "give either"),
        (lambda: layersplat.volshow(layersplat.Volume(array), 2.0), "leave it out"),
    ]:
        with pytest.raises(layersplat.InvalidValue, match=words):
            call()
    assert renderer.render(camera, 10).shape == (10, 10, 4), "and it goes on"


def test_limits_and_files(array, transfer, tmp_path):
    renderer = layersplat.Renderer(array, transfer)
    camera = renderer.camera(64)
    renderer.limit(0.0)
    with pytest.raises(layersplat.DeviceError, match="longer than its limit"):
        renderer.render(camera, 64)
    renderer.limit(None)
    renderer.render(camera, 64)
    with pytest.raises(layersplat.InvalidValue, match="limit"):
        renderer.limit(-1.0)
    with pytest.raises(OSError, match="cannot read"):
        layersplat.Volume.open(tmp_path / "missing_2x2x2_uint8.raw")


def test_vectors_may_be_arrays(array, transfer):
    camera = layersplat.Camera(np.array([0.0, 0.0, 9.0]), np.zeros(3), np.array([0, 1, 0]), scale=np.float32(2))
    assert camera.position == (0, 0, 9) and camera.scale == 2


def test_stubs_say_what_there_is():
    """Every class, method and argument of the native part, and no others."""
    file = pathlib.Path(layersplat.__file__).parent / "_layersplat.pyi"
    classes = {node.name: node for node in ast.parse(file.read_text()).body if isinstance(node, ast.ClassDef)}
    native = {name: found for name, found in vars(layersplat._layersplat).items() if inspect.isclass(found)}
    assert set(native) <= set(classes)
    for name, found in native.items():
        stubs = {node.name: node for node in classes[name].body if isinstance(node, ast.FunctionDef)}
        public = {member for member in vars(found) if not member.startswith("_")}
        assert {stub for stub in stubs if not stub.startswith("_")} == public, name
        for member in public | ({"__new__"} & set(stubs)):
            thing = found if member == "__new__" else getattr(found, member)
            assert member == "__new__" or thing.__doc__, f"{name}.{member} is not documented"
            if inspect.isgetsetdescriptor(thing):
                continue
            arguments = stubs[member].args
            said = [a.arg for a in arguments.args if a.arg not in ("self", "cls")] + [a.arg for a in arguments.kwonlyargs]
            has = [a for a in inspect.signature(thing).parameters if a != "self"]
            assert said == has, f"{name}.{member}"
            if member == "__new__":
                missing = [argument for argument in has if argument not in found.__doc__]
                assert not missing, f"{name} does not say what {missing} is"
    assert (file.parent / "py.typed").exists()
