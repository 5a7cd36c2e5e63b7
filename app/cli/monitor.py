"""`dps-s monitor`: prints the status as it streams, or polls it where the module does not stream.

The stream is switched on if it was off, and off again at the end, however it ends. When a conversation ends the reason
is printed on standard error, and the next one is polled: another module may answer. Exit code 0, also after Ctrl-C if a
status was received; 3 if the port was lost, or nobody answered for five seconds; 4 if no status was received.
"""

import argparse
import sys
from contextlib import nullcontext

from app.cli.results import MonitorJson
from app.engine.conversation import StatusSample
from app.engine.procedure import LinkView
from app.engine.worker import Batch
from app.limits.out_of_limits import DAMAGED_SHOWN_S, LimitsInUse, Outside, line_outside
from app.system.clock import steady_time
from app.terminal import console
from app.terminal.arguments import add_json, add_port, add_seconds
from app.terminal.connection import OpenPort
from app.terminal.interruption import print_after_signal
from app.terminal.streaming import StreamSpan, marks_in, stream
from app.text.i18n import tr
from app.text.sentences import labelled
from app.text.user_error import ErrorCode

LINE_EVERY_S = 0.1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        f"{parser.description} What is known of a module holds for one unbroken conversation. When it ends, the reason "
        "is printed and another module may answer from then on; its status is polled, the stream is not switched on "
        "again."
    )
    add_port(parser)
    add_seconds(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    span = StreamSpan(args.seconds)
    printer = JsonLines(span) if args.json else WordLines(span)
    trouble = stream(args.port, args.baud, span, on_batch=printer.on_batch, on_turn=printer.on_turn)
    with print_after_signal() if span.was_interrupted else nullcontext():
        printer.print_news()  # includes what came while the stream was switched off
        printer.finish()
    if trouble is not None:
        raise console.Refused(trouble, ErrorCode.NO_LINK)
    if not printer.count:
        console.notify(labelled(tr("Status"), tr("no reply")))
        return console.PARTIAL
    return console.SUCCESS


class JsonLines:
    """Prints the samples of the batches that lie in the span, each once: one JSON object a line."""

    def __init__(self, span: StreamSpan) -> None:
        self._span = span
        # In order of time, with what is said between two conversations.
        self._news: list[StatusSample | str] = []
        self.count = 0
        self.stream_hz = 0.0

    def on_turn(self, opened: OpenPort) -> None:
        self.stream_hz = opened.conversation.stream_hz
        self.judge_line(opened.link)
        self.print_news()

    def judge_line(self, link: LinkView | None) -> None:
        """For people only."""

    def on_batch(self, batch: Batch) -> None:
        for sample in batch.samples:
            if self._span.holds(sample.at):
                self._news.append(sample)
        if self._span.has_begun:
            self._news += marks_in(batch)

    def print_news(self) -> None:
        news, self._news = self._news, []
        samples: list[StatusSample] = []
        for one in news:
            if isinstance(one, StatusSample):
                samples.append(one)
                continue
            self._print_all(samples)
            samples = []
            self.finish()
            console.notify(one)
        self._print_all(samples)

    def _print_all(self, samples: list[StatusSample]) -> None:
        if samples:
            self.count += len(samples)
            self._print(samples)

    def _age_s(self, sample: StatusSample) -> float:
        return sample.at - (self._span.first_at or 0.0)

    def _print(self, samples: list[StatusSample]) -> None:
        """Print these, in order of time; at least one."""
        text = ""
        for sample in samples:
            line = MonitorJson(
                t_s=round(self._age_s(sample), 3),
                tilt_deg=sample.tilt_deg,
                acceleration_g=sample.acceleration_g,
                triggered=sample.triggered,
                active=sample.active,
            )
            text += console.as_json(line) + "\n"
        console.write(text)

    def finish(self) -> None:
        """End the output; every line has its end already."""


class WordLines(JsonLines):
    """For people: on a terminal one line that is updated, else at most ten lines a second. A status with a change of
    triggered or active always gets its own line."""

    def __init__(self, span: StreamSpan) -> None:
        super().__init__(span)
        self._is_rewriting = sys.stdout.isatty()
        self._before: StatusSample | None = None
        self._printed_at: float | None = None
        self._width = 0
        self._rejected = 0
        self._damaged_at: float | None = None
        self.line: Outside | None = None

    def judge_line(self, link: LinkView | None) -> None:
        """Find out whether the line is outside its limits."""
        if link is None:
            return
        now = steady_time()
        if link.counters.rejected > self._rejected:
            self._rejected, self._damaged_at = link.counters.rejected, now
        self.line = line_outside(
            lag_s=link.round_trip_median_s,
            round_trip_s=link.round_trip_median_s,
            has_damaged=self._damaged_at is not None and now - self._damaged_at < DAMAGED_SHOWN_S,
            in_use=LimitsInUse(),
        )

    def _print(self, samples: list[StatusSample]) -> None:
        for sample in samples:
            before, self._before = self._before, sample
            is_change = before is not None and (sample.triggered, sample.active) != (before.triggered, before.active)
            if is_change and self._is_rewriting:
                self.finish()
            is_due = self._printed_at is None or sample.at - self._printed_at >= LINE_EVERY_S
            if is_change or (is_due and not self._is_rewriting):
                self._write(sample)
        if self._is_rewriting:
            self._write(samples[-1])

    def _write(self, sample: StatusSample) -> None:
        self._printed_at = sample.at
        cells = (
            f"{self._age_s(sample):8.1f} s",
            f"{tr('Tilt')} {sample.tilt_deg:3}°",
            f"{sample.acceleration_g:4.1f} g",
            tr("TRIGGERED") if sample.triggered else tr("not triggered"),
            tr("active") if sample.active else tr("locked"),
        )
        words = "   ".join(cells)
        if self.line is not None:
            words = self.line.beside(words)
        if not self._is_rewriting:
            console.write(words + "\n")
            return
        words = console.fitted(f"{words}   {self.stream_hz:.0f} Hz" if self.stream_hz else f"{words}   –")
        console.write("\r" + console.padded(words, self._width))
        self._width = console.display_width(words)

    def finish(self) -> None:
        if self._is_rewriting and self._width:
            console.write("\n")
            self._width = 0
