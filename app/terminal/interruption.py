"""SIGINT, SIGTERM and SIGHUP while a port is open, and --timeout.

The handler only stores the signal's number, and the command looks at it ten times a second. So no signal interrupts a
line of output, or the switching off of a stream. Where a pipe that nobody reads blocks the output, an alarm a second
later breaks it off.
"""

import math
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, Final, TextIO

from app.text.i18n import tr

PATIENCE_S: Final = 1.0
# Not all platforms have all of them.
_SIGNALS: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


class Signalled(KeyboardInterrupt):
    """A signal asks the command to end. `number` is the signal's."""

    def __init__(self, number: int) -> None:
        super().__init__(f"signal {number}")
        self.number = number


class TimedOut(KeyboardInterrupt):
    """The time of --timeout is over, so the command ends as by a signal, but for its exit code."""

    def __init__(self, seconds: float) -> None:
        super().__init__()
        self.seconds = seconds

    @property
    def sentence(self) -> str:
        return tr("Not done within {seconds:g} s.", seconds=self.seconds)


class _Signals:
    """The signals of this process. `number` is that of the first one that came."""

    def __init__(self) -> None:
        self.number: int | None = None
        self.is_entered = False
        self.is_writing = False
        # The time of --timeout, and when it is over.
        self.timeout_s = self.ends_at = math.inf

    def note(self, number: int, _frame: FrameType | None) -> None:
        if self.number is None:
            self.number = number
            _set_alarm(PATIENCE_S)

    def give_up(self, _number: int, _frame: FrameType | None) -> None:
        if self.is_writing:
            raise Signalled(self.number or signal.SIGTERM)


_signals = _Signals()


@contextmanager
def signals_noted() -> Iterator[None]:
    """From now on signals are only noted, until the outermost block ends. Does nothing in other threads."""
    if _signals.is_entered or threading.current_thread() is not threading.main_thread():
        yield
        return
    handlers: dict[str, Callable[[int, FrameType | None], Any]] = dict.fromkeys(_SIGNALS, _signals.note)
    handlers["SIGALRM"] = _signals.give_up
    before: dict[int, Any] = {}
    for name, handler in handlers.items():
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            before[number] = signal.signal(number, handler)
    _signals.is_entered = True
    try:
        yield
    finally:
        _set_alarm(0.0)
        _signals.is_entered = False
        _signals.number = None
        for number, former in before.items():
            signal.signal(number, former)


def limit_time(seconds: float | None) -> None:
    """From now on the command may take so long; None: as long as it wants."""
    _signals.timeout_s = math.inf if seconds is None else seconds
    _signals.ends_at = time.monotonic() + _signals.timeout_s


def check_signals() -> None:
    """Raises `Signalled` if a signal came, and `TimedOut` if the time is over."""
    if _signals.number is not None:
        raise Signalled(_signals.number)
    if time.monotonic() >= _signals.ends_at:
        raise TimedOut(_signals.timeout_s)


@contextmanager
def writing() -> Iterator[None]:
    """Surrounds output, which the alarm breaks off."""
    _signals.is_writing = True
    try:
        yield
    finally:
        _signals.is_writing = False


def _set_alarm(every_s: float) -> None:
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, every_s, every_s)


def discard(stream: TextIO) -> None:
    """Lead to nowhere what is still buffered for this stream, and all that follows."""
    with suppress(OSError, ValueError):  # it is no file
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
