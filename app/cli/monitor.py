"""`dps-s monitor`: prints the status as it streams, or polls it where the module does not stream.

The stream is switched on where it was off, and off again at the end, however it ends. Exit code 0; 3 when the line went
dead; 4 when no status came in the whole time. Ended by Ctrl-C it is done, so 0, if there was a status.
"""

import argparse
import sys
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from app.terminal.console import (
    DONE,
    NO_LINK,
    PARTLY,
    add_json_argument,
    add_port_arguments,
    as_json,
    display_width,
    fitted,
    note,
    padded,
    say,
    seconds,
    write,
)
from app.text.i18n import tr
from protocol.translatable import marked

if TYPE_CHECKING:
    from app.engine.device import StatusSample
    from app.engine.procedure import LinkView
    from app.engine.worker import Batch
    from app.limits.out_of_limits import Outside
    from app.store.stream_memory import StreamMemory
    from app.terminal.connection import Conversation

LEFT_ON = marked("An earlier session had left the serial output on; it is switched off when this one ends.")
WITHOUT_STATUS_S = 5.0
"""With --seconds: how long to wait for a first status, beyond the time wanted."""
LINE_EVERY_S = 0.1


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser(
        "monitor",
        description=tr(
            "Print the status as it streams, or polled where the module does not stream, until Ctrl-C. The stream is "
            "switched on where it was off, and off again at the end. Times count from the first status."
        ),
    )
    add_port_arguments(parser)
    parser.add_argument("--seconds", type=seconds, metavar="S", help=tr("end S seconds after the first status"))
    add_json_argument(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    from app.terminal.connection import connected, link_trouble
    from app.terminal.interruption import Interrupted

    printer = JsonLines(args.seconds) if args.json else WordLines(args.seconds)
    trouble: str | None = None
    try:
        with (
            _stream_memory(args.port) as memory,
            connected(args.port, args.baud, on_batch=printer.on_batch) as conversation,
        ):
            printer.begin()
            trouble = _watch(conversation, printer, args, memory)
    except Interrupted:
        if not printer.count and not printer.has_news:
            raise
    except Exception as error:
        trouble = link_trouble(error)
        if trouble is None:
            raise
    # What came while the stream was being switched off belongs to it, too.
    printer.print_news()
    printer.finish()
    if trouble is not None:
        say(trouble)
        return NO_LINK
    if not printer.count:
        say(tr("The module on {port} answers, but reports no status.", port=args.port))
        return PARTLY
    return DONE


@contextmanager
def _stream_memory(port: str) -> "Iterator[StreamMemory]":
    """Where it is kept that the serial output is switched on; of no use for what is simulated or played."""
    from app.engine.ports import PortsUnknown, list_ports
    from app.engine.reconnect import address_of
    from app.store.database import StoreTrouble
    from app.store.store import open_store
    from app.store.stream_memory import StoredStreamMemory, StreamMemory

    if port.startswith(("sim:", "capture:", "loop:")):
        yield StreamMemory()
        return
    try:
        adapter = address_of(port, list_ports()).identity
    except PortsUnknown:
        adapter = ""
    try:
        store = open_store()
    except StoreTrouble as error:
        say(error.sentence)
        yield StreamMemory()
        return
    try:
        if store.notice is not None:
            say(store.notice)
        memory = StoredStreamMemory(store, adapter or port)
        yield memory
        if memory.is_taken_over:
            note(tr(LEFT_ON))
    finally:
        store.close()


def _watch(
    conversation: "Conversation", printer: "Printer", args: argparse.Namespace, memory: "StreamMemory"
) -> str | None:
    """Until the time is over: None; or the line went dead: the sentence that says so."""
    from app.procedures.stream import StreamSwitch, watch
    from protocol.link_states import Presence

    conversation.keep_running(watch(StreamSwitch(), read_all=False, memory=memory))
    gives_up_at = None if args.seconds is None else time.monotonic() + args.seconds + WITHOUT_STATUS_S
    while not printer.is_full:
        printer.stream_hz = conversation.device.stream_hz
        printer.look_at_line(conversation.link)
        printer.print_news()
        conversation.wait()
        conversation.check_running()
        if conversation.device.presence is Presence.OFFLINE:
            return tr("The module on {port} stopped answering. Check its power and the wiring.", port=args.port)
        if gives_up_at is not None and time.monotonic() > gives_up_at:
            break
    return None


class Printer(ABC):
    """Takes samples from the batches and prints them, all of the time wanted and none twice."""

    def __init__(self, seconds: float | None) -> None:
        self._seconds = seconds
        self._news: list[StatusSample] = []
        self._first_at: float | None = None
        self._is_begun = False
        self.count = 0
        self.is_full = False
        """The time wanted is over."""
        self.stream_hz = 0.0
        self.line: Outside | None = None
        self._rejected = 0
        self._damaged_at: float | None = None

    def begin(self) -> None:
        """From here on samples count; before it was only found out whether a module is there."""
        self._is_begun = True

    def look_at_line(self, link: "LinkView | None") -> None:
        """How the line is from now on."""
        from app.limits.out_of_limits import DAMAGED_SHOWN_S, LimitsInUse, line_outside

        if link is None:
            return
        now = time.monotonic()
        if link.counters.rejected > self._rejected:
            self._rejected, self._damaged_at = link.counters.rejected, now
        self.line = line_outside(
            lag_s=link.lag_s,
            round_trip_s=link.round_trip_median_s,
            has_damaged=self._damaged_at is not None and now - self._damaged_at < DAMAGED_SHOWN_S,
            in_use=LimitsInUse(),
        )

    @property
    def has_news(self) -> bool:
        return bool(self._news)

    def on_batch(self, batch: "Batch") -> None:
        for sample in batch.samples if self._is_begun else ():
            if self._first_at is None:
                self._first_at = sample.at
            if self._seconds is not None and sample.at - self._first_at > self._seconds:
                self.is_full = True
                return
            self._news.append(sample)

    def print_news(self) -> None:
        news, self._news = self._news, []
        if news:
            self.count += len(news)
            self._print(news)

    def _age_s(self, sample: "StatusSample") -> float:
        return sample.at - (self._first_at or 0.0)

    @abstractmethod
    def _print(self, samples: "list[StatusSample]") -> None:
        """These follow each other in time and are at least one."""

    @abstractmethod
    def finish(self) -> None:
        """Nothing follows."""


class JsonLines(Printer):
    """One object a line for every sample."""

    def _print(self, samples: "list[StatusSample]") -> None:
        write("".join(as_json(self._object(sample)) + "\n" for sample in samples))

    def _object(self, sample: "StatusSample") -> dict[str, object]:
        return {
            "t_s": round(self._age_s(sample), 3),
            "tilt_deg": sample.tilt_deg,
            "acceleration_g": sample.acceleration_g,
            "triggered": sample.triggered,
            "active": sample.active,
        }

    def finish(self) -> None:
        """Every line has ended."""


class WordLines(Printer):
    """For people: on a terminal one line that is always the latest, else ten lines a second at most.

    A status in which it triggered, or was activated or locked, always keeps a line of its own.
    """

    def __init__(self, seconds: float | None) -> None:
        super().__init__(seconds)
        self._is_rewriting = sys.stdout.isatty()
        self._before: StatusSample | None = None
        self._printed_at: float | None = None
        self._width = 0

    def _print(self, samples: "list[StatusSample]") -> None:
        for sample in samples:
            before, self._before = self._before, sample
            is_change = before is not None and sample[3:] != before[3:]
            if is_change and self._is_rewriting:
                write("\n")
                self._width = 0
            is_due = self._printed_at is None or sample.at - self._printed_at >= LINE_EVERY_S
            if is_change or (is_due and not self._is_rewriting):
                self._write(sample)
        if self._is_rewriting:
            self._write(samples[-1])

    def _write(self, sample: "StatusSample") -> None:
        self._printed_at = sample.at
        words = tr(
            "{seconds:8.1f} s   tilt {tilt:3}°   {acceleration:4.1f} g   {triggered}   {active}",
            seconds=self._age_s(sample),
            tilt=sample.tilt_deg,
            acceleration=sample.acceleration_g,
            triggered=tr("TRIGGERED") if sample.triggered else tr("not triggered"),
            active=tr("active") if sample.active else tr("locked"),
        )
        if self.line is not None:
            words = self.line.beside(words)
        if not self._is_rewriting:
            write(words + "\n")
            return
        rate = tr("{rate:.0f} a second", rate=self.stream_hz) if self.stream_hz else tr("polled")
        words = fitted(f"{words}   {rate}")
        write("\r" + padded(words, self._width))
        self._width = display_width(words)

    def finish(self) -> None:
        if self._is_rewriting and self._width:
            write("\n")
