"""The door for programs of others: open, read, write, watch, lock.

`docs/integrating.md` has examples. The names here stay. There is no activation and no deployment.
"""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from app.engine.conversation import StatusSample
from app.engine.procedure import Pause, Procedure, ask_report
from app.procedures.lock import Locked, lock
from app.procedures.read import Readings, read_everything
from app.procedures.stream import POLL_EVERY_S
from app.procedures.write import SettingChange, WriteContext, WriteReport, write_all
from app.settings.values import SETTINGS_BY_KEY
from app.system.clock import steady_time
from app.terminal import console
from app.terminal.connection import OpenPort, connected
from app.terminal.records import CommandStore
from protocol.catalogue import DEFAULT_BAUD_RATE
from protocol.fields import Value


class OpenModule:
    """An open module in one unbroken conversation. Where that ends, every method raises `Interrupted` from then on."""

    def __init__(self, port: OpenPort, store: CommandStore) -> None:
        self._port = port
        self._store = store

    def read_everything(self) -> Readings:
        """Ask once for everything that can be asked for."""
        return self._port.run(read_everything())

    def write(self, *, accepts_risk: bool = False, **settings: Value) -> WriteReport:
        """Write settings, such as `freefall_time_s=1.4`, and verify each by reading it back. Not the baud rate.

        `accepts_risk`: also values that take protection away. Raises `KeyError` for an unknown name and `ValueError`
        for a value that the module cannot have, before anything is sent.
        """
        changes = [SettingChange(SETTINGS_BY_KEY[key], value) for key, value in settings.items()]
        context = WriteContext(
            journal=self._store.journal,
            accepted_risks=frozenset(changes if accepts_risk else ()),
            keep_as_found=self._store.keep_as_found,
        )
        return self._port.run(write_all(changes, context))

    def watch(self, seconds: float) -> Iterator[StatusSample]:
        """Ask for the status ten times a second. The serial output is left as it is."""

        def next_report() -> Procedure[StatusSample | None]:
            yield Pause(POLL_EVERY_S)
            return (yield from ask_report())

        ends_at = steady_time() + seconds
        while steady_time() < ends_at:
            report = self._port.run(next_report())
            if report is not None:
                yield report

    def lock(self) -> Locked:
        """Send LOCK until the module reports LOCKED, for ten seconds at most. This is never refused."""
        return self._port.run(lock(self._store.journal), outlives=True)


@contextmanager
def opened(port: str, baud_rate: int = DEFAULT_BAUD_RATE) -> Iterator[OpenModule]:
    """Open a port and wait for a module; close it at the end.

    Raises `PortError`, or a `UserError` with a sentence, such as `NoLink` where none answers. Ctrl-C is raised by the
    next call, as nothing breaks off a frame.
    """
    console.start(argparse.Namespace(quiet=True))
    with console.signals_noted(), CommandStore(port) as store, connected(port, baud_rate) as line:
        yield OpenModule(line, store)
