"""How often a conversation ends without reason on lines of every kind, while one module answers all the time."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from app.procedures.stream import StreamSwitch, watch
from protocol.events import Began, Ended, Unanswered
from tests.campaigns.plug import PlugRig, Wear
from tests.module.module import Module
from tests.module.options import Options
from tests.support.line.sim_line import FakeClock

SPAN_S: Final = 60.0
"""After so long the module's log is cleared, and it is counted."""


@dataclass(frozen=True)
class BadLine:
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


@dataclass
class Found:
    """What happened on a line. `frames`: that the host sent, a second; `reports`: that came, a second."""

    seconds: float
    begins: int = 0
    ends: int = 0
    reasons: str = ""
    unanswered: int = 0
    frames: float = 0.0
    lag_s: float = 0.0
    silence_s: float = 0.0

    @property
    def ends_an_hour(self) -> float:
        return 3600.0 * self.ends / self.seconds


def run(line: BadLine, seconds: float, *, streams: bool, seed: int = 1) -> Found:
    """Watch one module, streamed or polled, as the window does."""
    clock = FakeClock()
    module = Module(Options(delay_s=line.answer_s), seed=seed, now=clock.now_s)
    switch = StreamSwitch(is_wanted=streams)
    rig = PlugRig(module, clock, line.wear, lambda: watch(switch), seed=seed)
    found, reasons, sent = Found(seconds), [], 0
    end_s = clock.now_s + seconds
    while clock.now_s < end_s:
        rig.step_for(min(SPAN_S, end_s - clock.now_s))
        for event in rig.events:
            found.begins += isinstance(event, Began)
            found.unanswered += isinstance(event, Unanswered)
            if isinstance(event, Ended):
                reasons.append(event.reason.value)
        rig.events.clear()
        module.log.clear()
        sent += len(rig.plug.sent)
        rig.plug.sent.clear()
    found.ends = len(reasons)
    found.reasons = ", ".join(sorted({f"{reason} {reasons.count(reason)}" for reason in reasons}))
    found.frames = sent / seconds
    found.lag_s = rig.session._link.lag_s or 0.0
    found.silence_s = rig.session._link.silence_s
    return found


def table(seconds: float, seeds: int) -> list[str]:
    """One line of text for each kind of line, polled and streamed."""
    texts = [f"{'line':<40}{'':<10}{'ends/h':>8}{'unanswered/h':>14}{'frames/s':>10}{'lag ms':>8}  reasons"]
    for name, line in LINES.items():
        for streams in (False, True):
            runs = [run(line, seconds, streams=streams, seed=seed) for seed in range(1, seeds + 1)]
            hours = seconds * seeds / 3600.0
            ends = sum(one.ends for one in runs) / hours
            unanswered = sum(one.unanswered for one in runs) / hours
            frames = sum(one.frames for one in runs) / seeds
            reasons = "; ".join(one.reasons for one in runs if one.reasons)
            how = "streamed" if streams else "polled"
            lag_ms = 1000 * max(one.lag_s for one in runs)
            texts.append(f"{name:<40}{how:<10}{ends:>8.1f}{unanswered:>14.1f}{frames:>10.1f}{lag_ms:>8.0f}  {reasons}")
    return texts
