"""Collects what a program must never do: exceptions that nobody caught, and errors in its log."""

import logging
import sys
import threading
import traceback
from types import TracebackType
from typing import Self


class Mistakes(logging.Handler):
    """In force inside a `with`; `texts` are what was caught."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(logging.Formatter("%(name)s: %(message)s").format(record))

    def __enter__(self) -> Self:
        self._hooks = sys.excepthook, threading.excepthook, sys.unraisablehook
        sys.excepthook = self._take
        threading.excepthook = lambda args: self._take(args.exc_type, args.exc_value, args.exc_traceback)
        sys.unraisablehook = lambda args: self._take(args.exc_type, args.exc_value, args.exc_traceback)
        logging.getLogger().addHandler(self)
        return self

    def __exit__(self, *_: object) -> None:
        logging.getLogger().removeHandler(self)
        sys.excepthook, threading.excepthook, sys.unraisablehook = self._hooks

    def _take(self, kind: type[BaseException], error: BaseException | None, trace: TracebackType | None, /) -> None:
        self.texts.append("".join(traceback.format_exception(kind, error, trace)))
