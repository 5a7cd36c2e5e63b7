"""A pseudo-terminal with one module on it, or with several. POSIX only."""

import os
import random
import select
import termios
import threading
import time
import tty
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from tests.module.module import Module

LONGEST_WAIT_S = 0.02
CHUNK = 4096
_SPEED = 4
"""Where `tcgetattr` has the rate of what is received."""


class Line:
    """Runs the modules in a thread; `port` is what the host opens.

    The rate that the host sets is read from the terminal: at another one than the module's own, each hears garbage.
    """

    def __init__(self, *modules: Module, keeps_rate: bool = True, link: str | None = None) -> None:
        self.modules: Sequence[Module] = modules
        self._keeps_rate = keeps_rate
        self._random = random.Random(1)
        self._host, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._host, False)
        self.port = os.ttyname(self._slave)
        self._link = link
        if link is not None:
            Path(link).unlink(missing_ok=True)
            Path(link).symlink_to(self.port)
            self.port = link
        self._ended = threading.Event()
        self._is_plugged = True
        self._thread = threading.Thread(target=self._run, name="tests.module", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._ended.set()
        self._thread.join()
        self.unplug()
        if self._link is not None:
            Path(self._link).unlink()

    @staticmethod
    def now() -> float:
        return time.monotonic()

    def unplug(self) -> None:
        """Take the adapter away; the host's reads and writes fail from then on."""
        self._ended.set()
        if threading.current_thread() is not self._thread and self._thread.is_alive():
            self._thread.join()
        if self._is_plugged:
            self._is_plugged = False
            os.close(self._host)
            os.close(self._slave)

    def host_rate(self) -> int | None:
        """Return the rate that the host set last, None for one that has no name here."""
        speeds = {getattr(termios, f"B{rate}"): rate for rate in (4800, 9600, 19200, 38400, 57600, 115200)}
        return speeds.get(termios.tcgetattr(self._slave)[_SPEED])

    def host_termios(self) -> list[object]:
        """Return what the host set, as `termios.tcgetattr` gives it."""
        return list(termios.tcgetattr(self._slave))

    def _run(self) -> None:
        while not self._ended.is_set():
            now = self.now()
            times = [at for module in self.modules if (at := module.next_at()) is not None]
            wait_s = min([LONGEST_WAIT_S, *(max(0.0, at - now) for at in times)])
            ready, _, _ = select.select([self._host], [], [], wait_s)
            if ready:
                self._hear()
            self._speak()

    def _hear(self) -> None:
        try:
            data = os.read(self._host, CHUNK)
        except OSError:  # nobody has opened it
            return
        for module in self.modules:
            module.hear(self._garbled(module, data), self.now())

    def _speak(self) -> None:
        for module in self.modules:
            if said := module.speak(self.now()):
                # What nobody reads is lost, as on a real line.
                with suppress(BlockingIOError):
                    os.write(self._host, self._garbled(module, said))

    def _garbled(self, module: Module, data: bytes) -> bytes:
        if not self._keeps_rate or self.host_rate() == module.rate:
            return data
        return self._random.randbytes(len(data))
