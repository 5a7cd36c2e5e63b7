"""Logs and reports uncaught exceptions of all threads."""

import logging
import sys
import threading
import traceback
from collections.abc import Callable
from types import TracebackType
from typing import NamedTuple

_log = logging.getLogger(__name__)


class UncaughtError(NamedTuple):
    """An uncaught exception. `details` is for the clipboard."""

    summary: str
    details: str
    thread: str


Hook = Callable[[UncaughtError], None]


def catch_uncaught_errors(on_uncaught: Hook) -> Callable[[], None]:
    """Log uncaught exceptions of all threads and pass them to `on_uncaught` instead of the terminal.

    Returns a function that restores the previous hooks. `on_uncaught` is called in the thread of the exception. Ctrl-C
    is not affected. For exceptions that had to be caught there is `report_uncaught_error`.
    """
    global _on_uncaught
    before, before_thread = sys.excepthook, threading.excepthook

    def caught(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        if issubclass(kind, KeyboardInterrupt):
            before(kind, error, trace)
            return
        _report(on_uncaught, error, trace)

    def caught_in_thread(args: threading.ExceptHookArgs) -> None:
        if args.exc_value is not None:
            _report(on_uncaught, args.exc_value, args.exc_traceback)

    def undo() -> None:
        global _on_uncaught
        sys.excepthook, threading.excepthook, _on_uncaught = before, before_thread, before_callback

    before_callback = _on_uncaught
    sys.excepthook, threading.excepthook, _on_uncaught = caught, caught_in_thread, on_uncaught
    return undo


def report_uncaught_error(error: BaseException) -> None:
    """Log and report an exception that was caught only so that its thread continues."""
    _report(_on_uncaught, error, error.__traceback__)


def _log_only(_error: UncaughtError) -> None:
    """Default outside of `catch_uncaught_errors`."""


_on_uncaught: Hook = _log_only


def _report(on_uncaught: Hook, error: BaseException, trace: TracebackType | None) -> None:
    thread = threading.current_thread().name
    details = "".join(traceback.format_exception(type(error), error, trace))
    _log.error("An error that nobody expected, in thread %s:\n%s", thread, details)
    try:
        on_uncaught(UncaughtError(f"{type(error).__name__}: {error}", details, thread))
    except Exception:  # noqa: BLE001  telling of one error must not make the next
        _log.exception("The error could not be told")
