"""Exceptions, and that stubs match the native module."""

import ast
import concurrent.futures
import errno
import inspect
import pathlib

import numpy as np
import pytest

import layersplat

PLACE = {"azimuth": 0.0}


def test_the_classes_derive_from_built_in_ones():
    for ours, pythons in [
        (layersplat.InvalidValue, ValueError),
        (layersplat.InvalidType, TypeError),
        (layersplat.DeviceError, RuntimeError),
        (layersplat.InternalError, RuntimeError),
        (layersplat.OutOfMemory, MemoryError),
        (layersplat.TimedOut, TimeoutError),
        (layersplat.Cancelled, concurrent.futures.CancelledError),
        (layersplat.FileError, OSError),
        (layersplat.FileNotFound, FileNotFoundError),
        (layersplat.PermissionDenied, PermissionError),
        (layersplat.InvalidFile, OSError),
        (layersplat.InvalidFile, ValueError),
    ]:
        assert issubclass(ours, pythons) and issubclass(ours, layersplat.Error)
    errors = {name for name in layersplat.__all__ if isinstance(getattr(layersplat, name), type) and issubclass(getattr(layersplat, name), Exception)}
    assert errors == {name for name in dir(layersplat._errors) if isinstance(getattr(layersplat._errors, name), type)}


class Scene:
    """The valid arguments of calls with one invalid argument."""

    def __init__(self, array, transfer):
        self.array, self.transfer, self.volume = array, transfer, layersplat.Volume(array)
        self.renderer = layersplat.Renderer(self.volume, transfer)
        self.camera = self.renderer.camera(10)


@pytest.fixture
def scene(array, transfer):
    return Scene(array, transfer)


WRONG_TYPES = [
    (lambda s: s.renderer.render(None, 10), "camera", "camera is None: expected a layersplat.Camera"),
    (lambda s: s.renderer.render(s.camera, "big"), "size", "size is 'big' (str): expected (width, height) in pixels, or one whole number"),
    (lambda s: s.renderer.render(s.camera, 10.5), "size", "size is 10.5 (float): expected"),
    (lambda s: s.renderer.render(s.camera, 10, "high"), "settings", "settings is 'high' (str): expected a layersplat.Settings"),
    (lambda s: s.renderer.render(s.camera, 10, background=5), "background", "background is 5 (int): expected transparent, black"),
    (lambda s: s.renderer.enqueue(s.camera, 10, s.array), "onto", "an object of pyopencl, or its int_ptr"),
    (lambda s: s.renderer.enqueue(s.camera, 10, 1, wait_for=5), "wait_for", "wait_for is 5 (int): expected a list"),
    (lambda s: s.renderer.camera(10, azimuth="x"), "azimuth", "azimuth is 'x' (str): expected a number"),
    (lambda s: setattr(s.renderer, "transfer", 5), "transfer", "expected a layersplat.TransferFunction"),
    (lambda s: layersplat.Renderer(s.array, s.transfer, device=1.5), "device", "device is 1.5 (float): expected a layersplat.Device, the index"),
    (lambda s: layersplat.Renderer(s.array, s.transfer, queue="x"), "queue", "queue is 'x' (str): expected an object of pyopencl"),
    (lambda s: layersplat.Device(1.5), "name", "the index of a device, or part of its name"),
    (lambda s: layersplat.DeviceVolume(1, 2, (3, 3, 3), 4), "device", "device is 1 (int): expected a layersplat.Device"),
    (lambda s: layersplat.DeviceVolume(layersplat.Device(), 1, (3, 3, 3), "foo"), "dtype", "dtype is 'foo' (str): expected a numpy type"),
    (lambda s: layersplat.Camera("abc", (0, 0, 0), scale=1), "position", "position is 'abc' (str): expected three numbers, (x, y, z)"),
    (lambda s: layersplat.Settings(kernel=5), "kernel", "kernel is 5 (int): expected a string"),
    (lambda s: layersplat.Settings(blend=3), "blend", "blend is 3 (int): expected composite, maximum"),
    (lambda s: layersplat.Settings(shading=3), "shading", "shading is 3 (int): expected True, False, or a dict of ambient"),
    (lambda s: layersplat.Settings(shading={"power": "x"}), "shading", "shading['power'] is 'x' (str): expected a number"),
    (lambda s: layersplat.Settings(shading={"light": (None, 1, "x")}), "shading", "(direction, strength, angle, (r, g, b)), or a list of up to four"),
    (lambda s: layersplat.Settings(shadows="on"), "shadows", "shadows is 'on' (str): expected True, False, a strength from 0 to 1, or a dict"),
    (lambda s: layersplat.Settings(shadows={"strength": "x"}), "shadows", "shadows['strength'] is 'x' (str): expected a number"),
    (lambda s: layersplat.Settings(ambient_occlusion=3), "ambient_occlusion", "expected True, False, or a dict of reach and gain"),
    (lambda s: layersplat.Settings(ambient_occlusion={"gain": None}), "ambient_occlusion", "ambient_occlusion['gain'] is None: expected a number"),
    (lambda s: layersplat.Settings(light_space=1), "light_space", "light_space is 1 (int): expected a string"),
    (lambda s: layersplat.Settings(planes=[1]), "planes", "planes is [1] (list): expected a list of (point, normal)"),
    (lambda s: layersplat.TransferFunction([1], [2]), "colors", "colors is [1] (list): expected a list of (value, (red, green, blue))"),
    (lambda s: layersplat.TransferFunction.builtin("fire", 5), "onto", "onto is 5 (int): expected a layersplat.Volume, or (lowest, highest)"),
    (lambda s: layersplat.Framing.of(s.array, s.transfer), "volume", "expected a layersplat.Volume"),
    (lambda s: layersplat.Volume.open(5), "path", "path is 5 (int): expected a path"),
    (lambda s: layersplat.Volume(s.array, {}), "spacing", "spacing is {} (dict): expected one number, or three"),
    (lambda s: layersplat.Volume(s.array, background="x"), "background", "background is 'x' (str): expected a number"),
    (lambda s: layersplat.transfer_function(s.volume, 5), "cmap", "cmap is 5 (int): expected a name, a file"),
    (lambda s: layersplat.transfer_function(s.volume, "fire", 5), "clim", "clim is 5 (int): expected two numbers"),
    (lambda s: layersplat.transfer_function(s.volume, opacity={}), "opacity", "opacity is {} (dict): expected a number, linear"),
    (lambda s: layersplat.volshow(s.array).save(5), "path", "path is 5 (int): expected a path"),
]

WRONG_COUNTS = [
    (lambda s: s.renderer.render(s.camera, (10,)), "size", "size is (10,) (tuple): expected (width, height)"),
    (lambda s: s.renderer.render(s.camera, -5), "size", "size is -5 (int): expected (width, height)"),
    (lambda s: layersplat.Camera((0, 0), (0, 0, 0), scale=1), "position", "position is (0, 0) (tuple): expected three numbers"),
    (lambda s: layersplat.Settings(density=-1), "density", "density is -1 (int): expected a whole number from 0 on"),
    (lambda s: layersplat.Volume(s.array, "abc"), "spacing", "spacing is 'abc' (str): expected one number"),
    (lambda s: layersplat.Volume([[1, 2], [3]]), "data", "data is [[1, 2], [3]] (list): expected an array (z, y, x)"),
    (lambda s: layersplat.transfer_function(s.volume, "fire", (1, 2, 3)), "clim", "clim is (1, 2, 3) (tuple): expected two numbers"),
]


@pytest.mark.parametrize(
    "call, field, words, error",
    [(*case, layersplat.InvalidType) for case in WRONG_TYPES] + [(*case, layersplat.InvalidValue) for case in WRONG_COUNTS],
)
def test_messages_name_the_argument_its_value_and_accepted_values(scene, call, field, words, error):
    with pytest.raises(error) as caught:
        call(scene)
    assert words in str(caught.value) and caught.value.fields == (field,)


def test_exceptions_of_a_callers_own_code_pass(scene):
    class Stubborn:
        def __float__(self):
            raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        scene.renderer.camera(10, azimuth=Stubborn())


@pytest.mark.parametrize("angle", ["azimuth", "elevation", "roll"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_angles_that_are_not_finite(scene, angle, value):
    framing = layersplat.Framing.of(scene.volume, scene.transfer)
    for call in [
        lambda: scene.renderer.camera(10, **{angle: value}),
        lambda: framing.camera(10, **{angle: value}),
        lambda: framing.camera(10, field_of_view=30, **{angle: value}),
        lambda: layersplat.Camera.orbit((0, 0, 0), 9, scale=1, **{angle: value}),
        lambda: layersplat.render(scene.volume, **{angle: value}),
    ]:
        with pytest.raises(layersplat.InvalidValue, match=f"{angle} is .*finite"):
            call()
    with pytest.raises(layersplat.InvalidValue, match="centre"):
        framing.camera(10, centre=(0, value, 0))


@pytest.mark.parametrize(
    "arguments, field, words",
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
        ({"shading": {"light": (None, 1, 46)}}, "light", "0 to 45 degrees"),
        ({"shading": {"light": (None, 1, 0, (0, 2, 0))}}, "light", "red, green and blue from 0 to 1"),
        ({"shadows": {"darkness": 1}}, "shadows", "use strength or forgiveness"),
        ({"ambient_occlusion": {"strength": 1}}, "ambient_occlusion", "use reach or gain"),
        ({"light_space": "eye"}, "light_space", "use world or camera"),
        ({"light_grid": "coarse"}, "light_grid", "use full, half or quarter"),
        ({"planes": [((0, 0, 0), (1, 0, 0))] * 7}, "clipping", "more than 6"),
        ({"extinction": "cubic"}, "extinction", "exponential or linear"),
        ({"layer_axis": "w"}, "layer_axis", "use auto"),
    ],
)
def test_settings(arguments, field, words):
    with pytest.raises(layersplat.InvalidValue, match=words) as caught:
        layersplat.Settings(**arguments)
    assert caught.value.fields == (field,)


def test_pictures(array, transfer):
    renderer = layersplat.Renderer(array, transfer)
    camera = renderer.camera(10)
    for call, words in [
        (lambda: renderer.render(camera, (0, 4)), "1 to 16384 pixels"),
        (lambda: renderer.render(camera, 10, background="pink"), "background 'pink'"),
        (lambda: renderer.render(camera, 10, background=(2, 0, 0)), "from 0 to 1"),
        (lambda: renderer.render(camera, 10, layersplat.Settings(unit_distance=-1)), "unit_distance"),
        (lambda: renderer.render(camera, 10, layersplat.Settings(shadows=1.5)), "shadow_strength is 1.5"),
        (lambda: renderer.render(camera, 10, layersplat.Settings(shadows={"forgiveness": 0})), "shadow_forgiveness is 0"),
        (lambda: renderer.render(camera, 10, layersplat.Settings(shadows=True, shading=False)), "shading is off"),
        (lambda: renderer.render(camera, 10, layersplat.Settings(ambient_occlusion={"reach": -1})), "ao_reach is -1"),
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
    with pytest.raises(layersplat.InvalidValue, match="red, green and blue from 0 to 1") as caught:
        renderer.render(camera, 10, layersplat.Settings(shading={"ambient_color": (0, 2, 0)}))
    assert caught.value.fields == ("ambient_color",)
    assert renderer.render(camera, 10).shape == (10, 10, 4), "the renderer stays usable"


def test_time_limits(array, transfer):
    renderer = layersplat.Renderer(array, transfer, time_limit=0.0)
    camera = renderer.camera(64)
    assert renderer.time_limit == 0.0
    for call in [renderer.render, renderer.render_float, renderer.depths]:
        with pytest.raises(layersplat.TimedOut, match="longer than its limit"):
            call(camera, 64)
    renderer.time_limit = None
    assert renderer.time_limit is None and renderer.render(camera, 64).shape == (64, 64, 4)
    renderer.time_limit = 0
    with pytest.raises(TimeoutError):
        renderer.render(camera, 64)
    for wrong in [-1.0, np.nan, np.inf]:
        with pytest.raises(layersplat.InvalidValue, match="time_limit is"):
            renderer.time_limit = wrong
        with pytest.raises(layersplat.InvalidValue, match="time_limit is"):
            layersplat.Renderer(array, transfer, time_limit=wrong)
    with pytest.raises(layersplat.InvalidType, match="time_limit is 'long'"):
        renderer.time_limit = "long"
    assert renderer.time_limit == 0.0


def test_files(array, tmp_path):
    missing = tmp_path / "missing_2x2x2_uint8.raw"
    with pytest.raises(FileNotFoundError, match="^cannot read .*missing_2x2x2") as caught:
        layersplat.Volume.open(missing)
    assert isinstance(caught.value, layersplat.FileError)
    assert pathlib.Path(caught.value.filename) == missing and caught.value.errno == errno.ENOENT
    short = tmp_path / "short_9x9x9_uint8.raw"
    short.write_bytes(b"text")
    with pytest.raises(layersplat.InvalidFile, match="729 bytes") as caught:
        layersplat.Volume.open(short)
    assert isinstance(caught.value, OSError) and isinstance(caught.value, ValueError) and pathlib.Path(caught.value.filename) == short
    with pytest.raises(FileNotFoundError, match="^cannot write") as caught:
        layersplat.volshow(array, size=9).save(tmp_path / "missing" / "view.png")
    assert isinstance(caught.value, layersplat.FileError) and caught.value.errno == errno.ENOENT


def test_a_renderer_is_unusable_after_a_panic(scene):
    """As in C: the state may be inconsistent after a panic."""
    with pytest.raises(layersplat.InternalError, match="layersplat panicked: in the middle"):
        scene.renderer._panic()
    calls = [
        lambda: scene.renderer.render(scene.camera, 10),
        lambda: scene.renderer.prepare(scene.camera, 10),
        lambda: scene.renderer.camera(10),
        lambda: scene.renderer.transfer,
        lambda: setattr(scene.renderer, "transfer", scene.transfer),
        lambda: setattr(scene.renderer, "time_limit", None),
    ]
    for call in calls:
        with pytest.raises(layersplat.InternalError, match="panicked in this renderer before.*make another"):
            call()
    assert layersplat.Renderer(scene.volume, scene.transfer).render(scene.camera, 10).shape == (10, 10, 4), "another one works"


def test_vectors_may_be_arrays(array, transfer):
    camera = layersplat.Camera(np.array([0.0, 0.0, 9.0]), np.zeros(3), np.array([0, 1, 0]), scale=np.float32(2))
    assert camera.position == (0, 0, 9) and camera.scale == 2


def test_stubs_match_the_native_module():
    """Stubs have every class, method and argument of the native module, and no others."""
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
            declared = [a.arg for a in arguments.args if a.arg not in ("self", "cls")] + [a.arg for a in arguments.kwonlyargs]
            actual = [a for a in inspect.signature(thing).parameters if a != "self"]
            assert declared == actual, f"{name}.{member}"
            if member == "__new__":
                missing = [argument for argument in actual if argument not in found.__doc__]
                assert not missing, f"{name} does not document {missing}"
    assert (file.parent / "py.typed").exists()
