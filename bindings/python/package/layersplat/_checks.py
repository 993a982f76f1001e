"""Errors of arguments, which name the argument, its value and the accepted values; and warnings."""

import contextlib
import os
import reprlib
import sys
import warnings
from typing import Any, Iterator

from ._errors import DataWarning, Error, FileError, FileNotFound, InvalidType, InvalidValue, PermissionDenied


@contextlib.contextmanager
def accepting(name: str, value: Any, expected: str) -> Iterator[None]:
    """Converts exceptions of Python and numpy for an invalid argument to errors of layersplat."""
    try:
        yield
    except Error:
        raise
    except TypeError as error:
        raise _refused(InvalidType, name, value, expected) from error
    except (ValueError, OverflowError) as error:
        raise _refused(InvalidValue, name, value, expected) from error


def _refused(kind: type, name: str, value: Any, expected: str) -> Error:
    shown = reprlib.repr(value) if value is None else f"{reprlib.repr(value)} ({type(value).__name__})"
    error: Error = kind(f"{name} is {shown}: expected {expected}")
    error.fields = (name,)
    return error


def cannot_write(path: Any, error: OSError) -> FileError:
    """The error of a file that could not be written."""
    kinds = {FileNotFoundError: FileNotFound, PermissionError: PermissionDenied}
    found = kinds.get(type(error), FileError)(f"cannot write {path}: {error.strerror}")
    found.filename, found.errno = error.filename, error.errno
    return found


def warn(text: str) -> None:
    """Emits a warning, attributed to the line outside this package that called it."""
    folder, level = os.path.dirname(__file__), 2
    frame = sys._getframe(1)
    while frame.f_back is not None and os.path.dirname(frame.f_code.co_filename) == folder:
        frame, level = frame.f_back, level + 1
    warnings.warn(text, DataWarning, stacklevel=level)
