"""`dps-s monitor`: prints the status as it streams, or polls it where the module does not stream.

The stream is switched on if it was off, and off again at the end, however it ends. What is known of a module holds for
one unbroken conversation: when one ends, the reason is printed on standard error, and the next one is polled, as
another module may answer. Exit code 0, also after Ctrl-C if a status was received; 3 if the port was lost, or nobody
answered for five seconds; 4 if no status was received.
"""

import argparse
import sys

from app.engine.conversation import StatusSample
from app.engine.worker import Batch
from app.limits.out_of_limits import DAMAGED_SHOWN_S, LimitsInUse, Outside, line_outside
from app.terminal import console
from app.terminal.arguments import add_json, add_port, add_seconds
from app.terminal.interruption import signals_noted
from app.terminal.results import Result
from app.terminal.streaming import Watching, ends_in
from app.text.i18n import tr
from app.text.sentences import labelled
from app.text.user_error import ErrorCode

LINE_EVERY_S = 0.1


class MonitorJson(Result):
    """One status report. `t_s`: seconds since the first one."""

    t_s: float
    tilt_deg: float
    acceleration_g: float
    triggered: bool
    active: bool


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    add_seconds(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    watching = Watching(args.port, args.baud, args.seconds)
    lines = StatusLines()
    with signals_noted():
        for batch in watching:
            first_s = watching.first_at or 0.0
            if args.json:
                reports = [MonitorJson.of(sample, t_s=round(sample.at - first_s, 3)) for sample in batch.samples]
                console.write_lines(map(console.as_json, reports))
            else:
                lines.print(batch, first_s)
            for end in ends_in(batch):
                lines.end()
                console.notify(end)
        lines.end()
    if watching.trouble is not None:
        raise console.Refused(watching.trouble, ErrorCode.NO_LINK)
    if watching.first_at is None:
        console.notify(labelled(tr("Status"), tr("no reply")))
        return console.PARTIAL
    return console.SUCCESS


class StatusLines:
    """For people: at most ten lines a second, but always one where triggered or active changes. On a terminal the same
    line is written again until then."""

    def __init__(self) -> None:
        self._is_terminal = sys.stdout.isatty()
        self._before: StatusSample | None = None
        self._rejected = 0
        self._damaged_at: float | None = None
        self._outside: Outside | None = None

    def print(self, batch: Batch, first_s: float) -> None:
        self._judge_line(batch)
        text = ""
        for sample in batch.samples:
            before = self._before
            is_change = before is not None and (sample.triggered, sample.active) != (before.triggered, before.active)
            if before is None or is_change or sample.at - before.at >= LINE_EVERY_S:
                text += self._line(sample, sample.at - first_s, is_change=is_change)
                self._before = sample
        console.write(text)

    def end(self) -> None:
        """End the line that would be written again."""
        if self._is_terminal and self._before is not None:
            console.write("\n")
        self._before = None

    def _judge_line(self, batch: Batch) -> None:
        link = batch.link
        if link is None:
            return
        if link.counters.rejected > self._rejected:
            self._rejected, self._damaged_at = link.counters.rejected, batch.at
        self._outside = line_outside(
            lag_s=link.round_trip_median_s,
            round_trip_s=link.round_trip_median_s,
            has_damaged=self._damaged_at is not None and batch.at - self._damaged_at < DAMAGED_SHOWN_S,
            in_use=LimitsInUse(),
        )

    def _line(self, sample: StatusSample, t_s: float, *, is_change: bool) -> str:
        cells = (
            f"{t_s:8.1f} s",
            f"{tr('Tilt')} {sample.tilt_deg:3}°",
            f"{sample.acceleration_g:4.1f} g",
            tr("TRIGGERED") if sample.triggered else tr("not triggered"),
            tr("active") if sample.active else tr("locked"),
        )
        words = "   ".join(cells)
        if self._outside is not None:
            words = self._outside.beside(words)
        if not self._is_terminal:
            return f"{words}\n"
        begin = "\n" if is_change else "\r" if self._before is not None else ""
        return f"{begin}{console.fitted(words)}\x1b[K"
