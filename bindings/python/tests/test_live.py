"""Live views without a browser: the messages of a page, as the widget's channel carries them."""

import gc
import io
import json
import pathlib
import re
import struct
import subprocess
import sys
import threading
import time
import weakref

import numpy as np
import pytest
from PIL import Image

import layersplat
from layersplat import _layersplat

REPOSITORY = pathlib.Path(__file__).parents[3]
SIZE = (96, 72)
PATIENCE = 120
"""Seconds; only a hang reaches it."""
STEPS = ["moving", "standard", "high", "half", "refined", "saved"]


class Page:
    """A page that speaks over the widget's channel."""

    def __init__(self, view, name="page"):
        self.view, self.name, self.revision, self.id = view, name, 0, 0
        self.texts, self.pictures, self.arrived = [], [], threading.Condition()
        widget = view.widget
        if not hasattr(widget, "pages_of_test"):
            widget.pages_of_test = {}
            # The comm of a process without a kernel carries nothing.
            widget.send = lambda content, buffers=None: widget.pages_of_test[content["page"]].take(content, buffers)
        widget.pages_of_test[name] = self
        self.say(open=True)

    def take(self, content, buffers):
        with self.arrived:
            self.revision = content["revision"]
            if "text" in content:
                self.texts.append(json.loads(content["text"]))
            for buffer in buffers or []:
                step, form, _, ident, width, height, ms = struct.unpack_from("<BBHIIIf", buffer)
                self.pictures.append({"step": STEPS[step], "jpeg": form == 0, "id": ident, "size": (width, height), "bytes": bytes(buffer[20:])})
            self.arrived.notify_all()

    def say(self, **content):
        self.view.widget._handle_custom_msg({"page": self.name, "revision": self.revision, **content}, [])

    def ask(self, request):
        self.say(text=json.dumps(request))

    def first(self, kind, count=1):
        """Waits for the n-th text of a kind."""
        return self.wait(lambda: [text for text in self.texts if text["type"] == kind], count)

    def wait(self, found, count=1):
        deadline = time.monotonic() + PATIENCE
        with self.arrived:
            while len(found()) < count:
                assert self.arrived.wait(deadline - time.monotonic()), self.texts[-3:]
            return found()[count - 1]

    def view_of(self, camera, moving=False, size=SIZE):
        self.id += 1
        self.ask({"type": "view", "id": self.id, "camera": camera, "width": size[0], "height": size[1], "moving": moving})
        return self.id

    def picture(self, step, ident=None):
        """Waits for a picture of a view, acknowledging others."""
        ident = self.id if ident is None else ident
        counted = 0
        while True:
            picture = self.wait(lambda: self.pictures, counted + 1)
            counted += 1
            self.ask({"type": "shown"})
            if picture["step"] == step and picture["id"] == ident:
                return picture


def pixels(picture):
    return np.asarray(Image.open(io.BytesIO(picture["bytes"])).convert("RGB"))


@pytest.fixture
def view(array):
    view = layersplat.volshow(array, cmap="fire", clim=(0, 255), size=SIZE)
    yield view
    view.close()


def turned(camera, by=40.0):
    return {**camera, "azimuth": camera["azimuth"] + by}


def test_a_page_begins_with_the_view_and_draws_it(view):
    page = Page(view)
    hello = page.first("hello")
    assert hello["camera_is_given"] and hello["camera"]["azimuth"] == pytest.approx(30) and hello["camera"]["roll"] == 0
    assert hello["look"]["quality"] is None and hello["look"]["background"] == "#000000"
    assert page.first("ready")["ready"] in (True, False)
    page.view_of(hello["camera"])
    drawn = page.picture("standard")
    assert drawn["size"] == SIZE and not drawn["jpeg"]
    # The angles passed through a camera and back.
    assert np.abs(pixels(drawn).astype(int) - view.render()[..., :3]).max() <= 1
    page.picture("refined")
    assert view.camera is None, "nothing was dragged"


def test_a_drag_sets_the_camera_and_angles_take_over_again(view):
    page, heard = Page(view), []
    view.observe(heard.append, names="camera")
    camera = page.first("hello")["camera"]
    for n in range(1, 4):
        page.view_of(turned(camera, 10.0 * n), moving=True)
    assert page.picture("moving")["jpeg"]
    assert [change.name for change in heard] == ["camera"] * 3 and heard[-1].new == heard[-1]["new"] == view.camera
    page.view_of(turned(camera, 30.0))
    # Bit for bit: the camera is the very one.
    assert np.array_equal(pixels(page.picture("standard")), view.render()[..., :3])
    assert len(heard) == 3, "the same camera is no change"
    view.azimuth = 75
    assert view.camera is None and heard[-1].new is None and heard[-1].old is not None
    given = page.first("given")["camera"]
    assert given["azimuth"] == pytest.approx(75) and given["elevation"] == pytest.approx(20)
    page.view_of(given)
    page.picture("standard")
    assert view.camera is None and len(heard) == 4, "what was given is no hand"


def test_the_light_of_the_studio_stays_in_the_world(array):
    view = layersplat.volshow(array, cmap="fire", clim=(0, 255), size=SIZE, settings=layersplat.Settings(look="studio"))
    page = Page(view)
    hello = page.first("hello")
    assert hello["look"]["studio"]["exposure"] == 0 and not hello["look"]["lights_follow"]
    page.ask({"type": "look", "look": hello["look"]})
    page.view_of(turned(hello["camera"]))
    drawn = pixels(page.picture("standard"))
    assert np.array_equal(drawn, view.render()[..., :3]), "stills have the light of the page"
    moved = layersplat.volshow(array, cmap="fire", clim=(0, 255), size=SIZE, camera=view.camera, settings=layersplat.Settings(look="studio"))
    assert np.abs(drawn.astype(int) - moved.render()[..., :3]).max() > 8, "light that moves with the camera differs"
    page.ask({"type": "look", "look": {**hello["look"], "studio": None, "lights": [], "lights_follow": True}})
    page.view_of(hello["camera"])
    page.picture("standard")
    assert view.settings == layersplat.Settings()
    view.close()


@pytest.mark.parametrize("name, value", [("elevation", 5), ("roll", 10), ("zoom", 2.0), ("field_of_view", 30.0), ("azimuth", 30.0)])
def test_every_angle_takes_over(view, name, value):
    page = Page(view)
    page.view_of(turned(page.first("hello")["camera"]))
    assert view.camera is not None
    setattr(view, name, value)
    assert view.camera is None and getattr(view, name) == value
    assert "perspective" in page.first("given")["camera"]["projection"] or name != "field_of_view"


def test_settings_transfer_and_background_follow_the_hand(view, transfer):
    page, heard = Page(view), []
    view.observe(heard.append, names=["settings", "transfer", "background"])
    hello = page.first("hello")
    page.ask({"type": "look", "look": {**hello["look"], "blend": "maximum", "background": "#102030"}})
    page.ask({"type": "transfer", "colors": [[0, [0, 0, 1]], [255, [1, 0, 0]]], "opacities": [[0, 0], [255, 0.25]]})
    assert view.settings == layersplat.Settings(blend="maximum") and view.background == "#102030"
    assert list(view.transfer.opacities) == [(0, 0), (255, 0.25)] and view._renderer.transfer == view.transfer
    assert [change.name for change in heard] == ["settings", "background", "transfer"]
    page.view_of(hello["camera"])
    followed = pixels(page.picture("standard"))
    assert np.abs(followed.astype(int) - view.render()[..., :3]).max() <= 1
    # And the other way round.
    view.settings, view.transfer = layersplat.Settings("high", shading={"power": 50}), transfer
    given = page.first("given", 2)
    assert given["look"]["quality"] == "high" and given["look"]["blend"] == "composite"
    page.ask({"type": "look", "look": given["look"]})
    page.ask({"type": "transfer", "colors": given["transfer"]["colors"], "opacities": given["transfer"]["opacities"]})
    page.view_of(given["camera"])
    assert np.abs(pixels(page.picture("refined")).astype(int) - view.render()[..., :3]).max() <= 1
    assert view.settings == layersplat.Settings("high", shading={"power": 50}), "what a look does not have stays"


def test_labels_that_color_the_volume_follow_the_hand(array, tmp_path, monkeypatch):
    ids = np.where(np.arange(array.shape[2]) < 14, 3, 7)[None, None].repeat(20, 0).repeat(24, 1)
    labels = layersplat.Labels(ids, {3: {"name": "left", "color": "#ff0000"}, 7: "#0000ff"})
    view, heard = layersplat.volshow(array, cmap="grey", size=SIZE, label_colors=labels), []
    view.observe(heard.append, names="label_colors")
    page = Page(view)
    hello = page.first("hello")
    assert [label["name"] for label in hello["labels"]] == ["left", "label 7"] and "slices" in hello["unavailable"]
    first = view.render()
    page.view_of(hello["camera"])
    assert np.abs(pixels(page.picture("standard")).astype(int) - first[..., :3]).max() <= 1
    look = {**hello["look"], "labels": {"only": [], "hidden": ["7"], "colors": [["3", "#00ff00"]]}}
    page.ask({"type": "look", "look": look})
    page.view_of(turned(hello["camera"], 0.0))
    drawn = pixels(page.picture("standard"))
    assert len(heard) == 1 and view.label_colors is heard[0].new and view.label_colors.table[7]["visible"] is False
    assert np.abs(drawn.astype(int) - view.render()[..., :3]).max() <= 1 and (view.render() != first).any()
    # What the program sets keeps what the hand has changed.
    view.background = "white"
    assert page.first("given")["look"]["labels"] == look["labels"] and view.label_colors.table[3]["color"] == (0, 1, 0)
    page.ask({"type": "save", "camera": hello["camera"], "width": SIZE[0], "height": SIZE[1], "samples": 1, "format": "png"})
    code = page.first("command")["line"]
    assert 'label_colors=labels.changed(["3:#00ff00", "7:hide"])' in code, code
    view.close()


def test_what_the_program_sets_is_newer_than_what_the_page_did_not_know(view):
    page = Page(view)
    camera = page.first("hello")["camera"]
    view.azimuth = 60
    page.revision = 0
    page.view_of(turned(camera, 99))
    assert view.camera is None
    page.picture("standard")
    page.revision = view.widget._revision
    page.view_of(turned(camera, 98))
    assert view.camera is not None


def test_two_pictures_are_on_their_way_at_most(view):
    page = Page(view)
    camera = page.first("hello")["camera"]
    for count in (1, 2, 3):
        last = [page.view_of(turned(camera, 20 * count + n), moving=True) for n in range(20)][-1]
        if count < 3:
            page.wait(lambda: page.pictures, count)
    time.sleep(0.3)
    assert len(page.pictures) == 2
    page.ask({"type": "shown"})
    assert page.wait(lambda: page.pictures, 3)["id"] == last, "the newest request wins"


def test_handlers_store_requests_and_wait_for_no_picture(view):
    """A thread draws with the interpreter lock released; it needs the lock to send only. So while this thread keeps the lock, requests are
    taken and nothing arrives."""
    page = Page(view)
    camera = page.first("hello")["camera"]
    interval = sys.getswitchinterval()
    try:
        sys.setswitchinterval(1000)
        before = len(page.pictures)
        page.id += 1
        request = {"type": "view", "id": page.id, "camera": turned(camera), "width": 96, "height": 72, "moving": False}
        view.widget._handle_custom_msg({"page": "page", "revision": 0, "text": json.dumps(request)}, [])
        assert len(page.pictures) == before
    finally:
        sys.setswitchinterval(interval)
    page.picture("refined")


def test_errors_are_sentences_in_the_page(view):
    page = Page(view)
    hello = page.first("hello")
    page.ask({"type": "look", "look": {**hello["look"], "background": "pink"}})
    assert "background" in page.first("problem")["sentence"]
    for text in ["", "{}", "[]", '{"type":"open","path":"/etc/passwd"}', "x" * (2 << 20)]:
        page.say(text=text)
    for content in [{}, {"page": 5}, {"page": "other", "text": "{}"}, {"page": "page", "text": 5}]:
        view.widget._handle_custom_msg(content, [])
    page.view_of(hello["camera"])
    page.picture("standard")
    page.say(asks=True)


def test_pages_of_a_view_are_bounded_and_have_cameras_of_their_own(view):
    pages = [Page(view, f"page {n}") for n in range(10)]
    assert list(view.widget._pages) == [f"page {n}" for n in range(2, 10)]
    camera = pages[9].first("hello")["camera"]
    pages[9].view_of(turned(camera))
    pages[9].picture("standard")
    pages[8].view_of(camera)
    pages[8].picture("standard")
    assert not any(text["type"] == "given" for text in pages[8].texts)
    for page in pages:
        page.say(closed=True)
    assert not view.widget._pages


def painters(expected):
    """Waits until this process has so many drawing threads: they name themselves, and leave the list, a moment later."""
    deadline = time.monotonic() + PATIENCE
    while sum(task.read_text() == "painter\n" for task in pathlib.Path("/proc/self/task").glob("*/comm")) != expected:
        assert time.monotonic() < deadline, expected
        time.sleep(0.01)


@pytest.mark.skipif(sys.platform != "linux", reason="threads are counted in /proc")
def test_what_is_closed_or_forgotten_leaves_no_thread_and_no_widget(array):
    gc.collect()
    painters(0)
    view = layersplat.volshow(array, size=SIZE)
    page = Page(view)
    page.view_of(page.first("hello")["camera"])
    painters(1)
    view.close()
    painters(0)
    again = Page(view)
    again.view_of(again.first("hello")["camera"])
    again.picture("standard")
    # Not forgotten while a page is open; then it is.
    gone = weakref.ref(view)
    view.widget.pages_of_test.clear()
    name, widget = again.name, view.widget
    del view, again, page
    gc.collect()
    assert gone() is not None
    painters(1)
    widget._handle_custom_msg({"page": name, "closed": True}, [])
    gc.collect()
    assert gone() is None
    painters(0)


ENDS = """import sys
sys.path.insert(0, {folder!r})
import numpy, layersplat, test_live
z, y, x = numpy.mgrid[-1:1:48j, -1:1:48j, -1:1:48j]
view = layersplat.volshow(numpy.exp(-4 * (x**2 + y**2 + z**2)), cmap="fire", opacity="linear")
page = test_live.Page(view)
camera = page.first("hello")["camera"]
page.view_of(camera, moving=True)
page.wait(lambda: page.pictures)
page.view_of(camera, size=(900, 900))
"""


def test_python_ends_while_a_page_is_drawn():
    code = ENDS.format(folder=str(pathlib.Path(__file__).parent))
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, timeout=PATIENCE, text=True)
    assert (ended.returncode, ended.stderr) == (0, "")


def test_the_copied_code_makes_the_saved_picture(view, array, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = Page(view)
    hello = page.first("hello")
    page.ask({"type": "look", "look": {**hello["look"], "shadows": True, "background": "#203040", "crop": [[0, 0, 0], [20.5, 22, 17]]}})
    camera = {**turned(hello["camera"], 33.3), "roll": 12.5}
    page.ask({"type": "save", "camera": camera, "width": 80, "height": 60, "samples": 1})
    saved = page.picture("saved", 0)
    command = page.first("command")
    pathlib.Path(command["transfer_name"]).write_text(command["transfer_text"])
    exec(command["line"], {"layersplat": layersplat, "data": array})
    found = np.asarray(Image.open("layersplat.png").convert("RGB"))
    assert np.array_equal(found, pixels(saved)) and found.max() > 60


def test_observers_hear_changes_only_and_can_leave(array):
    view = layersplat.volshow(array, size=SIZE)
    heard = []
    view.observe(heard.append)
    view.zoom, view.size = 1.0, SIZE
    assert heard == []
    view.zoom = 2.0
    (change,) = heard
    assert (change.name, change.old, change.new, change.owner, change.type) == ("zoom", 1.0, 2.0, view, "change")
    view.unobserve(heard.append)
    view.zoom = 3.0
    assert len(heard) == 1
    with pytest.raises(layersplat.InvalidType):
        view.transfer = "fire"
    assert isinstance(view.transfer, layersplat.TransferFunction)


def test_without_anywidget_the_still_is_shown(array, monkeypatch):
    monkeypatch.setitem(sys.modules, "anywidget", None)
    monkeypatch.delitem(sys.modules, "layersplat._live", raising=False)
    view = layersplat.volshow(array, size=SIZE)
    with pytest.raises(ImportError, match="layersplat\\[widget\\]"):
        view.widget
    with pytest.raises(NotImplementedError):
        view._ipython_display_()


def lines(path):
    """Lines of a module that the joined one has too."""
    text = re.sub(r"^import [^;]*;\n", "", path.read_text(), flags=re.M)
    return [re.sub(r"^export ", "", line) for line in text.splitlines() if line.strip()]


def test_the_joined_module_is_that_of_its_sources():
    joined = _layersplat.PAGE_MODULE.splitlines()
    page = REPOSITORY / "src/viewer/page"
    imported = {"main.js"}
    while True:
        texts = [(page / name).read_text() for name in imported]
        more = imported | {name for text in texts for name in re.findall(r'^(?:import|\}) .*from "\./(.*?)";', text, flags=re.M)}
        if more == imported:
            break
        imported = more
    assert imported == {path.name for path in page.glob("*.js")}, "every module is used"
    sources = [page / name for name in imported] + [REPOSITORY / "bindings/python/widget/widget.js"]
    for source in sources:
        name = re.sub(r"[^A-Za-z0-9]", "_", source.name)
        start = joined.index(f"const {name} = (() => {{")
        end = next(n for n in range(start, len(joined)) if joined[n].startswith("return { ") and joined[n + 1] == "})();")
        body = iter(joined[start:end])
        missing = [line for line in lines(source) if line not in body]
        assert not missing, f"{source.name}: {missing[:3]}"
    assert (REPOSITORY / "bindings/python/widget/widget.css").read_text() in _layersplat.PAGE_MODULE
    for outside in ["http://", "https://", "import(", "importScripts"]:
        found = [line for line in joined if outside in line.replace("http://www.w3.org/2000/svg", "") and "@" not in line]
        assert not [line for line in found if not line.lstrip().startswith(("//", "*", "/*"))], outside
