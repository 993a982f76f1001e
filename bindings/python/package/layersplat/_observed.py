"""Attributes whose changes are observed, with the interface of traitlets, which is not needed."""

import threading
from typing import Any, Callable, Dict, Generic, Iterable, List, Optional, Tuple, Type, TypeVar, Union, overload

T = TypeVar("T")


class Change(Dict[str, Any]):
    """A change of an attribute: ``name``, ``old``, ``new``, ``owner`` and ``type``, as items and as attributes."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None


Handler = Callable[[Change], Any]
Names = Union[None, str, Iterable[str]]


class Attribute(Generic[T]):
    """An attribute of an Observed."""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, owner: None, kind: type) -> "Attribute[T]": ...

    @overload
    def __get__(self, owner: "Observed", kind: Type["Observed"]) -> T: ...

    def __get__(self, owner: Optional["Observed"], kind: type) -> Any:
        return self if owner is None else owner._values[self.name]

    def __set__(self, owner: "Observed", value: T) -> None:
        owner._set({self.name: value})


class Observed:
    """An object that tells handlers what changes."""

    def __init__(self) -> None:
        self._values: Dict[str, Any] = {}
        self._handlers: List[Tuple[Handler, Optional[frozenset]]] = []
        # Held while attributes change: a hand and a cell may change them on different threads.
        self._lock = threading.RLock()

    def observe(self, handler: Handler, names: Names = None) -> None:
        """Calls handler with a change (``name``, ``old``, ``new``, ``owner``) after each of these attributes has changed; by default any."""
        self._handlers.append((handler, _named(names)))

    def unobserve(self, handler: Handler, names: Names = None) -> None:
        """Ends what ``observe`` with the same arguments began."""
        self._handlers.remove((handler, _named(names)))

    def _set(self, values: Dict[str, Any]) -> None:
        """Changes attributes by the program."""
        self._notify(self._assign(values))

    def _assign(self, values: Dict[str, Any]) -> List[Change]:
        """Assigns values. Returns what has changed."""
        with self._lock:
            changes = [
                Change(name=name, old=self._values.get(name), new=value, owner=self, type="change")
                for name, value in values.items()
                if not _is_same(self._values.get(name), value)
            ]
            self._values.update(values)
        return changes

    def _notify(self, changes: List[Change]) -> None:
        for change in changes:
            for handler, names in list(self._handlers):
                if names is None or change["name"] in names:
                    handler(change)


def _named(names: Names) -> Optional[frozenset]:
    if names is None:
        return None
    return frozenset([names] if isinstance(names, str) else names)


def _is_same(old: Any, new: Any) -> bool:
    if old is new:
        return True
    equal = old == new
    return type(old) is type(new) and bool(equal.all() if hasattr(equal, "all") else equal)
