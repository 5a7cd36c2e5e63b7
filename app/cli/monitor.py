"""`dps-s monitor`: prints the status as it streams, or polls it where the module does not stream.

The stream is switched on if it was off, and off again at the end, however it ends. What is known of a module holds for
one unbroken conversation: when one ends, the reason is printed on standard error, and the next one is polled, as
another module may answer. Exit code 0, also after Ctrl-C if a status was received; 3 if the port was lost, or nobody
answered for five seconds; 4 if no status was received.
"""

import argparse
import math
from collections.abc import Callable
from contextlib import suppress
from typing import Final

from app.diagnosis.causes import PortEvidence
from app.diagnosis.silence import Silence
from app.engine.conversation import reason_message
from app.engine.procedure import Procedure
from app.engine.worker import Batch
from app.procedures.stream import LISTEN_S, StreamSwitch, watch
from app.safety.last_known import was_heard_active
from app.store.acts import StreamMemory
from app.system.clock import steady_time
from app.terminal import console
from app.terminal.connection import adapter_of, connected, no_link
from app.terminal.records import CommandStore
from app.terminal.results import Result
from app.text.i18n import tr
from app.text.messages import join_sentences, labelled
from protocol.events import Ended, EndReason

SILENT_FOR_S: Final = 5.0  # nobody answers for so long, or no status comes


class MonitorJson(Result):
    """One status report. `t_s`: seconds since the first one."""

    t_s: float
    tilt_deg: float
    acceleration_g: float
    triggered: bool
    active: bool


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seconds", type=console.seconds, default=math.inf, metavar="S", help="end after S seconds")


def run(args: argparse.Namespace) -> int:
    first_at: float | None = None

    def show(batch: Batch) -> None:
        nonlocal first_at
        lines: list[str] = []
        # For people one of each batch: they come ten times a second, and at once where triggered or active changes.
        for sample in batch.samples if args.json else batch.samples[-1:]:
            first_at = sample.at if first_at is None else first_at
            t_s = sample.at - first_at
            if args.json:
                lines.append(console.as_json(MonitorJson.of(sample, t_s=round(t_s, 3))))
            else:
                fired = tr("TRIGGERED") if sample.triggered else tr("not triggered")
                words = f"{t_s:8.1f} s   {tr('Tilt')} {sample.tilt_deg:3}°   {sample.acceleration_g:4.1f} g   {fired}"
                lines.append(f"{words}   {tr('active') if sample.active else tr('locked')}")
        console.write_lines(lines)

    watch_port(args, show)
    if first_at is None:
        console.notify(labelled(tr("Status"), tr("no reply")))
        return console.PARTIAL
    return console.SUCCESS


def watch_port(
    args: argparse.Namespace, on_batch: Callable[[Batch], object], *, goes_on: Callable[[], bool] = lambda: True
) -> None:
    """Give all that comes from a port to `on_batch`, in order and through the ends of conversations, which are told;
    until a signal, or for `--seconds` from the first status, and while `goes_on`. Raises one of `LOST`, and the signal
    that comes before a status.

    In the first conversation the module is made to stream, and its serial output is switched off again at the end.
    After a break another module may answer: from then on the status is only polled.
    """
    conversations = 0

    def take(batch: Batch) -> None:
        on_batch(batch)
        for event in batch.events:
            # An end of the port is said otherwise.
            if isinstance(event, Ended) and event.reason not in (EndReason.CLOSED, EndReason.PORT_LOST):
                why = reason_message(event.reason, event.contradiction).translated()
                console.notify(join_sentences((why, tr("Another module may answer from now on."))))

    def background() -> Procedure[None]:
        nonlocal conversations
        conversations += 1
        # A module that answers after a break is not made to stream, but a stream of this program is switched off.
        return watch(StreamSwitch(), memory=memory, listen_s=LISTEN_S if conversations == 1 else math.inf)

    def is_over() -> bool:
        ended = opened.conversation.ended
        if ended is not None and steady_time() - ended.at > SILENT_FOR_S:
            was_active = was_heard_active(opened.conversation)
            raise no_link(PortEvidence(args.port, silence=Silence.NOTHING, was_online=True, was_active=was_active))
        return not goes_on()

    with CommandStore() as store:
        # It is remembered that the serial output is switched on.
        memory = StreamMemory(store, adapter_of(args.port) or args.port)
        with connected(args.port, args.baud, on_batch=take, background=background) as opened:
            opened.wait_until(lambda: "tilt_deg" in opened.conversation.values, SILENT_FOR_S)
            with suppress(KeyboardInterrupt):
                opened.wait_until(is_over, args.seconds)
