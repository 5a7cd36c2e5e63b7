"""Faults of the line or the module by name, as options of the simulated module or as events.

The options are those of `dps-s simulate` and the lies of `tests.support.line.lies`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from app.simulator.bench import SimulatedBench
from tests.support.line.odd_module import forget_settings

DIALECTS: Final[Mapping[str, Mapping[str, str]]] = {
    "as printed": {},
    "ack one": {"ack": "one"},
    "voltage 34": {"voltage_code": "34"},
    "freefall 17": {"freefall_ack": "17"},
    "records spaced": {"records": "spaced"},
    "records in pieces": {"records": "pieces"},
    "empty slots 00": {"empty_slots": "zeros"},
    "empty slots FF": {"empty_slots": "ones"},
    "baud at once": {"baud_ack": "new"},
    "baud at restart": {"baud_ack": "restart"},
    "light inverted": {"light_inverted": "yes"},
    "odd voltage": {"odd_voltage": "yes"},
    "remembers": {"remembers": "yes"},
    "no stream": {"stream": "acknowledged"},
    "silent stream": {"stream": "silent"},
    "streams at boot": {"stream_at_boot": "yes"},
}


@dataclass(frozen=True, slots=True)
class Accident:
    """An event of the module at a time after the start of the command."""

    at_s: float
    happen: Callable[[SimulatedBench], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Trouble:
    options: Mapping[str, str] = field(default_factory=dict)
    accident: Accident | None = None
    forges: bool = False
    """Valid frames with wrong contents arrive."""
    withholds: bool = False
    """A record is omitted twice in the same way, which cannot be detected."""


def _lie(**options: str) -> Trouble:
    return Trouble(options=options)


def _forgery(**options: str) -> Trouble:
    return Trouble(options=options, forges=True)


def _accident(at_s: float, happen: Callable[[SimulatedBench], None]) -> Trouble:
    return Trouble(accident=Accident(at_s, happen))


def _forget(bench: SimulatedBench) -> None:
    bench.restart()
    forget_settings(bench.module.memory)


def _slip(bench: SimulatedBench) -> None:
    bench.unplug()
    bench.plug()


def _change(bench: SimulatedBench, **values: Any) -> None:
    for name, value in values.items():
        setattr(bench.module.memory, name, value)


LINE: Final[Mapping[str, Trouble]] = {
    "nothing": Trouble(),
    "drop 10 %": _lie(drop="0.1"),
    "drop 30 %": _lie(drop="0.3"),
    "requests dropped": _lie(drop="0.2", direction="to-module"),
    "bytes lost": _lie(lose="0.01"),
    "corrupt 0.2 %": _forgery(corrupt="0.002"),
    "corrupt 2 %": _forgery(corrupt="0.02"),
    "requests corrupted": _forgery(corrupt="0.01", direction="to-module"),
    "corrupt both ways": _forgery(corrupt="0.01", direction="both"),
    "garbage": _forgery(garbage="0.2"),
    "doubled": _lie(double="0.2"),
    "all doubled": _lie(double="1"),
    "requests doubled": _lie(double="0.3", direction="to-module"),
    "late": _lie(delay_ms="400"),
    "too late": _lie(delay_ms="1100"),
    "jitter": _lie(jitter_ms="300"),
    "split": _lie(split_ms="8"),
    "echo": _lie(echo="yes"),
    "mute": _lie(mute="yes"),
    "needs a gap": _lie(min_gap_ms="30"),
    "half duplex": _lie(half_duplex="yes"),
    "wireless lag": _lie(lag_ms="350"),
    "lag and loss": _lie(lag_ms="250", drop="0.1"),
    "unplugged": _accident(0.15, SimulatedBench.unplug),
    "unplugged later": _accident(1.2, SimulatedBench.unplug),
    "plug slipped": _accident(0.3, _slip),
}
LIES: Final[Mapping[str, Trouble]] = {
    "keeps nothing": _lie(keeps="no"),
    "clamps": _lie(clamps="yes"),
    "refuses": _lie(refuses="yes"),
    "time writes acceleration": _lie(cross_talk="22:21=09"),
    "time writes threshold": _lie(cross_talk="22:20=14"),
    "acceleration writes threshold": _lie(cross_talk="21:20"),
    "threshold writes light": _lie(cross_talk="20:15=01"),
    "light writes time later": _lie(cross_talk="15:22=05@400"),
    "everything writes threshold": _lie(cross_talk="15:20=14@50,16:20=14@50,17:20=14@50,21:20=14@50,22:20=14@50"),
    "a trigger writes threshold": _lie(cross_talk="16:20=C8,17:20=C8"),
    "a trigger disables the other": _lie(cross_talk="16:17=01"),
    "a set activates": _lie(cross_talk="20:10=01,21:10=01,22:10=01,15:10=01,16:10=01"),
    "zero writes threshold": _lie(cross_talk="25:20=05"),
    "activation writes threshold": _lie(cross_talk="10:20=14"),
    "reverts after 20 ms": _lie(revert_ms="20"),
    "reverts after 300 ms": _lie(revert_ms="300"),
    "clamps after 0.5 s": _lie(clamp_ms="500"),
    "reverts and clamps": _lie(revert_ms="120", clamp_ms="60"),
    "changes after one read": _lie(read_changes="20:20=14/1@5,21:21=09/1@5,22:22=05/1@5,15:15=01/1@5"),
    "changes after two reads": _lie(read_changes="20:20=14/2@50,21:21=09/2@50,22:22=05/2@50,15:15=01/2@50"),
    "changes after three reads": _lie(read_changes="20:20=14/3@20"),
    "changes while watched": _lie(read_changes="32:20=C8/12"),
    "changes after the status": _lie(read_changes="32:20=14/1"),
    "activates while watched": _lie(read_changes="32:10=01/9"),
    "locks while watched": _lie(read_changes="32:10=00/9"),
    "silent restart after a set": _lie(silent_restart_ms="30"),
    "silent restart later": _lie(silent_restart_ms="350"),
    "silent restart, forgets": _lie(silent_restart_ms="30", forgets="yes"),
    "silent restart at 0.1 s": _lie(restart_at_s="60.1", forgets="yes"),
    "silent restart at 0.6 s": _lie(restart_at_s="60.6"),
    "silent restart at 1.6 s": _lie(restart_at_s="61.6", forgets="yes"),
    "restart": _accident(0.25, SimulatedBench.restart),
    "restart later": _accident(1.3, SimulatedBench.restart),
    "restart, forgets": _accident(0.5, _forget),
    "switched off": _accident(0.4, SimulatedBench.power_off),
    "record lost in pass 2 and 3": _lie(drop_records="1/2,1/3"),
    "record lost in pass 1": _lie(drop_records="2/1"),
    "record withheld twice": Trouble(options={"drop_records": "2/1,2/2"}, withholds=True),
    "all records lost in pass 2 and 3": _lie(drop_records=",".join(f"{n}/{p}" for n in range(1, 10) for p in (2, 3))),
    "records never answered": _lie(mute_codes="35"),
    "records answered once": _lie(mute_codes="35/2"),
    "threshold answered once": _lie(mute_codes="20/2"),
    "boot count never answered": _lie(mute_codes="23"),
    "status never answered": _lie(mute_codes="32"),
    "heartbeat answered five times": _lie(mute_codes="01/6"),
    "sets never answered": _lie(mute_codes="10,16,17,24"),
    "heartbeat doubled": _lie(double_codes="01", double_ms="50"),
    "settings doubled": _lie(double_codes="20,21,22,15", double_ms="15"),
    "records doubled": _lie(double_codes="35", double_ms="40"),
    "acknowledgements doubled late": _lie(double_codes="10,12,16,17,24,25", double_ms="300"),
    "foreign answers": _lie(foreign_replies="20:22,21:20,22:15,15:21,23:34,32:30"),
    "foreign acknowledgements": _lie(foreign_replies="32:10,01:12,20:16,23:25"),
    "forged answers in between": _forgery(foreign_replies="20:22=05,21:20=14,15:21=09"),
    "forged answers late": _forgery(foreign_replies="20:22=05@30,21:20=14@30,22:15=01@30"),
    "foreign records": _lie(foreign_replies="32:35,01:35"),
    "stream jitters": _lie(stream_at_boot="yes", stream_jitter_ms="30"),
    "slow stream jitters": _lie(stream_at_boot="yes", stream_jitter_ms="900", rate="1"),
    "activates without effect": _lie(activates="no"),
    "locks without effect": _lie(locks="no"),
    "active reported late": _lie(active_late_ms="500"),
    "zeroes without effect": _lie(zeroes="no"),
    "shuts down without effect": _lie(shuts_down="no"),
    "loses settings and restarts": _lie(forgets="yes", restart_at_s="60.3"),
    "memory changes": _accident(0.5, partial(_change, attitude_threshold=20)),
    "memory changes later": _accident(2.0, partial(_change, attitude_threshold=20, freefall_time=5)),
    "memory changes while it stands": _accident(16.0, partial(_change, attitude_threshold=20)),
    "tips over": _accident(0.6, lambda bench: bench.set_world(tilt_deg=75)),
    "somebody activates": _accident(0.3, lambda bench: bench.module.activate(is_active=True)),
    "somebody locks": _accident(0.3, lambda bench: bench.module.activate(is_active=False)),
}
TROUBLES: Final[Mapping[str, Trouble]] = {**LINE, **LIES}
