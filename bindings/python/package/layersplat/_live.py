"""A view that is live in a notebook: the viewer's page in a cell. Needs anywidget."""

import atexit
import base64
import json
import weakref
from typing import TYPE_CHECKING, Any, Dict, List, Optional

import anywidget
import traitlets

from ._errors import Error
from ._layersplat import PAGE_MODULE, LivePage

if TYPE_CHECKING:
    from ._show import View

WIDGETS: "weakref.WeakSet[Widget]" = weakref.WeakSet()
"""All widgets. A driver that is unloaded while it draws crashes the process, so their threads end before."""
MOST_PAGES = 8
"""Most open pages of a view. A browser that is reloaded does not say that its pages are gone: the one that was heard last goes."""


class Widget(anywidget.AnyWidget):  # type: ignore[misc]
    """The widget of a view. Its messages carry those of the page: a name for each page, the newest state that it knows, and text or a
    picture. Handlers store requests only; a thread of the library draws."""

    _esm = PAGE_MODULE
    size = traitlets.Tuple(traitlets.Int(), traitlets.Int()).tag(sync=True)
    still = traitlets.Unicode().tag(sync=True)
    """Class of the still picture that stands before the widget in a saved notebook."""

    def __init__(self, view: "View") -> None:
        self._pages: Dict[str, LivePage] = {}
        self._revision = 0
        self._owner = weakref.ref(view)
        # Keeps a view that is on display and that no variable names.
        self._kept: Optional["View"] = view
        super().__init__(size=view._viewport())
        self.still = f"layersplat-still-{self.model_id}"
        self.on_msg(self._hear)
        WIDGETS.add(self)

    def still_picture(self, png: bytes) -> str:
        """HTML of the picture of a saved notebook."""
        width, height = self.size
        data = base64.b64encode(png).decode()
        return f'<img class="{self.still}" width="{width}" height="{height}" alt="The volume" src="data:image/png;base64,{data}">'

    def give(self) -> None:
        """Shows what the program has changed."""
        view = self._owner()
        if view is None:
            return
        self.size = view._viewport()
        if not self._pages:
            return
        with view._lock:
            self._revision += 1
            view._show()
            camera, transfer = view._camera(), view.transfer
            for page in self._pages.values():
                page.give(camera, transfer)

    def close(self) -> None:
        """Ends all pages, and the widget."""
        self.end_pages()
        super().close()

    def end_pages(self) -> None:
        """Ends the threads that draw."""
        for name in list(self._pages):
            self._end_page(name)
        self._kept = None

    def _hear(self, _widget: Any, content: Dict[str, Any], _buffers: List[Any]) -> None:
        name, view = content.get("page"), self._owner()
        if not isinstance(name, str) or view is None:
            return
        try:
            if content.get("open"):
                self._begin_page(name, view)
            elif content.get("closed"):
                self._end_page(name)
            elif content.get("asks"):
                self._tell(name)
            elif name in self._pages and isinstance(content.get("text"), str):
                # The one that was heard last is the last.
                self._pages[name] = page = self._pages.pop(name)
                self._follow_hand(view, page, content["text"], content.get("revision"))
        except Error as error:
            self._tell(name, json.dumps({"type": "problem", "sentence": str(error)}))

    def _begin_page(self, name: str, view: "View") -> None:
        self._kept = view
        while len(self._pages) >= MOST_PAGES:
            self._end_page(next(iter(self._pages)))
        # The thread that draws outlives no widget: it must not keep one.
        widget = weakref.ref(self)

        def send(text: Optional[str], picture: Optional[bytes]) -> None:
            found = widget()
            if found is not None:
                found._tell(name, text, picture)

        with view._lock:
            view._show()
            self._pages[name] = view._scene.page(view._camera(), view.transfer, send)

    def _follow_hand(self, view: "View", page: LivePage, text: str, revision: Any) -> None:
        with view._lock:
            # A page that does not know the newest state yet only draws: what the program has set is newer.
            changes = view._follow(dict(page.receive(text, revision == self._revision)))
        view._notify(changes)

    def _end_page(self, name: str) -> None:
        page = self._pages.pop(name, None)
        if page is not None:
            page.close()
        if not self._pages:
            self._kept = None

    def _tell(self, name: str, text: Optional[str] = None, picture: Optional[bytes] = None) -> None:
        content: Dict[str, Any] = {"page": name, "revision": self._revision}
        if text is not None:
            content["text"] = text
        self.send(content, None if picture is None else [picture])


@atexit.register
def _end() -> None:
    for widget in list(WIDGETS):
        widget.end_pages()
