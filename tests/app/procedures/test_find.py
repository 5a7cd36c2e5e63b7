"""The search for a module's baud rate: "no" is said only after the vendor's second."""

from collections import Counter
from collections.abc import Callable
from types import MappingProxyType

import pytest

from app.engine.device import DeviceView
from app.engine.procedure import Ask, Effect, EngineView, LinkView, Pause, Procedure, UseRate
from app.procedures.baud import look_for
from app.procedures.find import SETTLE_S, find_rate
from app.procedures.handshake import Silence, _silence
from app.procedures.read import read_everything
from protocol.catalogue import BAUD_RATES
from protocol.events import Counters, Role, Unanswered
from protocol.frame import Reason
from tests.support.line.sim_line import Rig


@pytest.mark.parametrize("delay_ms", [0.0, 400.0, 760.0, 900.0, 980.0])
@pytest.mark.parametrize("rate", [115200, 9600])
def test_a_module_that_uses_the_vendors_second_is_found(rate: int, delay_ms: float) -> None:
    rig = Rig({"baud": rate, "delay_ms": delay_ms})
    assert rig.run(find_rate()).baud_rate == rate
    rig = Rig({"baud": rate, "delay_ms": delay_ms})
    assert rig.run(look_for(57600, 38400)) == rate


def test_a_slow_module_that_does_not_know_a_question_is_not_called_dead() -> None:
    rig = Rig({"delay_ms": 900.0, "mute_codes": "14"})
    everything = rig.run(read_everything())
    assert not everything.is_line_dead
    assert set(everything.errors) == {"light_v"}


def seen(frames: int = 0, echoes: int = 0, rejected: int = 0) -> EngineView:
    counters = Counters(
        frames=frames,
        by_role=Counter({Role.ECHO: echoes}),
        rejected_bytes=Counter({Reason.NO_HEADER: rejected}),
    )
    return EngineView(0.0, 0.0, 115200, DeviceView(MappingProxyType({})), LinkView(counters, None, None, 0, None))


@pytest.mark.parametrize(
    ("after", "silence"),
    [
        (seen(5, 5, 5), Silence.NOTHING),
        (seen(7, 7, 5), Silence.ECHO),
        (seen(7, 6, 5), Silence.OTHER_FRAMES),
        (seen(7, 7, 6), Silence.GARBAGE),
        (seen(6, 5, 6), Silence.OTHER_FRAMES),
        (seen(5, 5, 6), Silence.GARBAGE),
    ],
)
def test_a_silence_is_told_by_what_came_since(after: EngineView, silence: Silence) -> None:
    assert _silence(seen(5, 5, 5), after) is silence


@pytest.mark.parametrize("look", [lambda: look_for(57600, 38400), find_rate], ids=["look_for", "find_rate"])
def test_after_each_change_of_the_rate_the_line_settles(look: Callable[[], Procedure[object]]) -> None:
    search = look()
    effects: list[Effect] = []
    answer: object = None
    try:
        while True:
            effects.append(search.send(answer))
            answer = Unanswered(effects[-1].request, 1, 1.0, 0.0) if isinstance(effects[-1], Ask) else seen()
    except StopIteration:
        pass
    changes = [number for number, effect in enumerate(effects[:-1]) if isinstance(effect, UseRate)]
    assert len(changes) >= len(BAUD_RATES)
    assert {effects[number + 1] for number in changes} == {Pause(SETTLE_S)}
    assert isinstance(effects[-1], UseRate)
