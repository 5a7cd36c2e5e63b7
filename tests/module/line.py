"""A pseudo-terminal with one module on it, or with several. POSIX only."""

import os
import random
import select
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, Self

from tests.module.module import Module
from tests.module.wire import RATES

if sys.platform != "win32":
    import termios
    import tty

LONGEST_WAIT_S = 0.02
CHUNK = 4096
now = time.monotonic
"""The clock of all modules on lines."""
_SPEED = 4
"""Where `tcgetattr` has the rate of what is received."""


class Line:
    """Runs the modules in a thread; `port` is what the host opens.

    The rate that the host sets is read from the terminal: at another one than the module's own, each hears garbage.
    """

    def __init__(self, *modules: Module, link: str | None = None) -> None:
        self.modules = modules
        """A test may put others in their place while it runs, as somebody who moves the plug."""
        self._random = random.Random(1)
        self._host, self.slave = os.openpty()
        tty.setraw(self.slave)
        os.set_blocking(self._host, False)
        self.port = os.ttyname(self.slave)
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

    def __exit__(self, *_: object) -> None:
        self.unplug()
        if self._link is not None:
            Path(self._link).unlink(missing_ok=True)

    def unplug(self) -> None:
        """Take the adapter away; the host's reads and writes fail from then on."""
        self._ended.set()
        if threading.current_thread() is not self._thread and self._thread.is_alive():
            self._thread.join()
        if self._is_plugged:
            self._is_plugged = False
            os.close(self._host)
            os.close(self.slave)

    def host_rate(self) -> int | None:
        """Return the rate that the host set last, None for one that has no name here."""
        speeds = {getattr(termios, f"B{rate}"): rate for rate in RATES.values()}
        return speeds.get(self.host_termios()[_SPEED])

    def host_termios(self) -> list[Any]:
        """Return what the host set, as `termios.tcgetattr` gives it."""
        return termios.tcgetattr(self.slave)

    def _run(self) -> None:
        while not self._ended.is_set():
            wait_s = LONGEST_WAIT_S
            for module in self.modules:
                wait_s = max(0.0, min(wait_s, module.next_at() - now()))
            ready, _, _ = select.select([self._host], [], [], wait_s)
            if ready:
                self._hear()
            if not self._ended.is_set():
                self._speak()

    def _hear(self) -> None:
        try:
            data = os.read(self._host, CHUNK)
        except OSError:  # nobody has opened it
            return
        for module in self.modules:
            if self._is_plugged:  # the one before may have pulled it
                module.hear(self._garbled(module, data), now())

    def _speak(self) -> None:
        for module in self.modules:
            if said := module.speak(now()):
                # What nobody reads is lost, as on a real line.
                with suppress(BlockingIOError):
                    os.write(self._host, self._garbled(module, said))

    def _garbled(self, module: Module, data: bytes) -> bytes:
        if self.host_rate() == module.rate:
            return data
        return self._random.randbytes(len(data))
