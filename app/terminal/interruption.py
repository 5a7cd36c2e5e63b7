"""SIGINT, SIGTERM, SIGHUP: switch the stream off, then exit.

The handler only stores the signal's number, which the command checks ten times a second. So no signal interrupts a
line of output, or the switching off that it causes. If the main thread is blocked writing into a pipe that nobody
reads, an alarm raises the exception after a second.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, Final, Self

from app.terminal.console import discard_output

PATIENCE_S: Final = 1.0
_SIGNALS: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
"""Not all platforms have all of them."""

_Handler = Callable[[int, FrameType | None], Any] | int | None


class Signalled(KeyboardInterrupt):
    """A signal asks the command to end. `number` is the signal's."""

    def __init__(self, number: int) -> None:
        super().__init__(f"signal {number}")
        self.number = number


class Interruption:
    """Handles signals while it is entered; does nothing in other threads than the main one."""

    def __init__(self) -> None:
        self._number: int | None = None
        self._is_patient = True
        self._before: dict[int, _Handler] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is not threading.main_thread():
            return self
        outer = getattr(signal.getsignal(signal.SIGINT), "__self__", None)
        if isinstance(outer, Interruption):
            self._number = outer._number  # a signal that came before this one was entered
        for name in _SIGNALS:
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
                self._before[number] = signal.signal(number, self._note)
        if hasattr(signal, "SIGALRM"):
            self._before[signal.SIGALRM] = signal.signal(signal.SIGALRM, self._interrupt)
        return self

    def __exit__(self, *_error: object) -> None:
        self.ignore_from_now()
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before.clear()

    def check(self) -> None:
        """Raises `Signalled` if a signal came."""
        if self._number is not None:
            raise Signalled(self._number)

    def ignore_from_now(self) -> None:
        """From now on no alarm raises: the command cleans up, which takes a bounded time."""
        self._is_patient = False
        if self._before and hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0)

    def _note(self, number: int, _frame: FrameType | None) -> None:
        if self._number is None:
            self._number = number
            if self._is_patient and hasattr(signal, "setitimer"):
                signal.setitimer(signal.ITIMER_REAL, PATIENCE_S)

    def _interrupt(self, _number: int, _frame: FrameType | None) -> None:
        if self._is_patient and self._number is not None:
            self._is_patient = False
            discard_output()
            raise Signalled(self._number)


@contextmanager
def print_after_signal() -> Iterator[None]:
    """For output after a signal: discarded if a pipe does not take it within a second."""
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "SIGALRM"):
        yield
        return
    before = signal.signal(signal.SIGALRM, lambda _number, _frame: discard_output())
    signal.setitimer(signal.ITIMER_REAL, PATIENCE_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
