"""Logs the exceptions that nobody caught, of all threads, and tells them."""

import logging
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

_log = logging.getLogger(__name__)


class UncaughtError(NamedTuple):
    """`details`, with the name of the thread, is for the clipboard."""

    summary: str
    details: str


# Who is told, beside the log: the last one.
_listeners: list[Callable[[UncaughtError], None]] = []


@contextmanager
def uncaught_errors_told(tell: Callable[[UncaughtError], None]) -> Iterator[None]:
    """Log uncaught exceptions and pass them to `tell` instead of the terminal; it is called in their thread."""
    before = sys.excepthook, threading.excepthook

    def caught_in_thread(args: threading.ExceptHookArgs) -> None:
        if args.exc_value is not None:
            report_uncaught_error(args.exc_value)

    sys.excepthook = lambda _kind, error, _trace: report_uncaught_error(error)
    threading.excepthook = caught_in_thread
    _listeners.append(tell)
    try:
        yield
    finally:
        sys.excepthook, threading.excepthook = before
        _listeners.remove(tell)


def report_uncaught_error(error: BaseException) -> None:
    # Log and tell an exception, also one that was caught only so that its thread goes on.
    details = f"{threading.current_thread().name}\n{''.join(traceback.format_exception(error))}"
    _log.error("An error that nobody expected, in thread %s", details)
    for tell in _listeners[-1:]:
        try:
            tell(UncaughtError(f"{type(error).__name__}: {error}", details))
        except Exception:  # noqa: BLE001  telling of one error must not make the next
            _log.exception("The error could not be told")
