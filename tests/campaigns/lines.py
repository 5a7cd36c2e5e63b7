"""How often a conversation ends without reason on lines of every kind, while one module answers all the time."""

from collections import Counter
from collections.abc import Mapping
from typing import Final, NamedTuple

from app.procedures.stream import StreamSwitch, watch
from protocol.events import Began, Ended, Unanswered
from tests.campaigns.plug import PlugRig, Wear
from tests.module.module import Module
from tests.module.options import Options
from tests.support.line.sim_line import FakeClock

SPAN_S: Final = 60.0
"""After so long what was sent and logged is forgotten."""


class BadLine(NamedTuple):
    wear: Wear
    answer_s: float = 0.002
    """How long the module takes to answer."""


LINES: Final[Mapping[str, BadLine]] = {
    "good": BadLine(Wear()),
    "loses 5 %": BadLine(Wear(loss=0.05)),
    "loses 10 %": BadLine(Wear(loss=0.10)),
    "repeats a fifth, 0.25 to 0.8 s later": BadLine(Wear(repeats=0.2)),
    "0.7 s late": BadLine(Wear(lag_s=0.7)),
    "up to 0.7 s late": BadLine(Wear(jitter_s=0.7)),
    "half duplex": BadLine(Wear(is_half_duplex=True)),
    "half duplex, loses 5 %": BadLine(Wear(is_half_duplex=True, loss=0.05)),
    "answers take 50 ms, loses 5 %": BadLine(Wear(loss=0.05), answer_s=0.05),
    "answers take 100 ms": BadLine(Wear(), answer_s=0.1),
    "answers take 100 ms, loses 5 %": BadLine(Wear(loss=0.05), answer_s=0.1),
    "answers take 250 ms": BadLine(Wear(), answer_s=0.25),
    "answers take 250 ms, loses 5 %": BadLine(Wear(loss=0.05), answer_s=0.25),
}


class Found(NamedTuple):
    begins: int
    ends: Counter[str]
    """By reason."""
    unanswered: int


def watched(line: BadLine, seconds: float, *, streams: bool, seed: int = 1) -> Found:
    """Watch one module, streamed or polled, as the window does."""
    clock = FakeClock()
    module = Module(Options(delay_s=line.answer_s), seed=seed, now=clock.now_s)
    switch = StreamSwitch(is_wanted=streams)
    rig = PlugRig(module, clock, line.wear, lambda: watch(switch), seed=seed)
    begins, unanswered, ends = 0, 0, Counter[str]()
    end_s = clock.now_s + seconds
    while clock.now_s < end_s:
        rig.step_for(min(SPAN_S, end_s - clock.now_s))
        begins += sum(isinstance(event, Began) for event in rig.events)
        unanswered += sum(isinstance(event, Unanswered) for event in rig.events)
        ends.update(event.reason.value for event in rig.events if isinstance(event, Ended))
        for kept in rig.events, module.log, rig.plug.sent:
            kept.clear()
    return Found(begins, ends, unanswered)
