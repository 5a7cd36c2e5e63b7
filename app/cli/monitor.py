"""`dps-s monitor`: prints the status as it streams, or polls it where the module does not stream.

The stream is switched on if it was off, and off again at the end, however it ends. What is known of a module holds for
one unbroken conversation: when one ends, the reason is printed on standard error, and the next one is polled, as
another module may answer. Exit code 0, also after Ctrl-C if a status was received; 3 if the port was lost, or nobody
answered for five seconds; 4 if no status was received.
"""

import argparse
from collections.abc import Iterable

from app.engine.conversation import StatusSample
from app.terminal import console
from app.terminal.arguments import add, add_port, add_seconds
from app.terminal.interruption import signals_noted
from app.terminal.results import Result
from app.terminal.streaming import Watching
from app.text.i18n import tr
from app.text.messages import ErrorCode, labelled

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
    add(parser, "--json")


def run(args: argparse.Namespace) -> int:
    watching = Watching(args.port, args.baud, args.seconds)
    last: StatusSample | None = None
    with signals_noted():
        for batch in watching:
            shown = list(batch.samples) if args.json else _worth_a_line(last, batch.samples)
            last = shown[-1] if shown else last
            lines: list[str] = []
            for sample in shown:
                t_s = sample.at - (watching.first_at or 0.0)
                is_json = args.json
                lines.append(
                    console.as_json(MonitorJson.of(sample, t_s=round(t_s, 3))) if is_json else _line(sample, t_s)
                )
            console.write_lines(lines)
    if watching.trouble is not None:
        raise console.Refused(watching.trouble, ErrorCode.NO_LINK)
    if watching.first_at is None:
        console.notify(labelled(tr("Status"), tr("no reply")))
        return console.PARTIAL
    return console.SUCCESS


def _worth_a_line(last: StatusSample | None, samples: Iterable[StatusSample]) -> list[StatusSample]:
    """For people: ten a second at most, and each where triggered or active changes."""
    shown: list[StatusSample] = []
    for sample in samples:
        is_change = last is not None and (sample.triggered, sample.active) != (last.triggered, last.active)
        if last is None or is_change or sample.at - last.at >= LINE_EVERY_S:
            shown.append(sample)
            last = sample
    return shown


def _line(sample: StatusSample, t_s: float) -> str:
    cells = (
        f"{t_s:8.1f} s",
        f"{tr('Tilt')} {sample.tilt_deg:3}°",
        f"{sample.acceleration_g:4.1f} g",
        tr("TRIGGERED") if sample.triggered else tr("not triggered"),
        tr("active") if sample.active else tr("locked"),
    )
    return "   ".join(cells)
