"""The search for a module's baud rate: "no" is said only after the vendor's second."""

from collections import Counter
from collections.abc import Callable

import pytest

from app.engine.procedure import Ask, Effect, EngineView, Pause, Procedure, Report, Slept, UseRate
from app.engine.run import Run
from app.engine.transport import PortError, PortTrouble
from app.procedures.find import ROUNDS, SETTLE_S, find_rate, look_for
from app.procedures.handshake import NoAnswer, Silence, _silence
from app.procedures.light_calibration import measure_light
from app.procedures.read import READABLE, read_everything
from app.procedures.settings_reading import read_settings
from app.procedures.write_all import SettingChange, WriteContext, write_all
from app.safety.acts import Act
from app.safety.journal import NoJournal
from app.text.messages import UserMessage
from protocol.catalogue import BAUD_RATES, BY_NAME
from protocol.events import Counters, Role, Unanswered
from protocol.frame import Reason
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import Rig, engine_view


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
    return engine_view(counters=counters)


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


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (NoAnswer("/dev/x", 9600, Silence.ECHO), "/dev/x: no answer at 9600 baud: echo"),
        (PortError(PortTrouble.LOST, "/dev/x", "gone"), "/dev/x: lost: gone"),
        (Slept(90.0), "the computer slept for 90 s"),
        (NoJournal(UserMessage("no disk")).begin(Act.LOCK, b"", {}).exception(0.0), "no disk"),
        (NoJournal(UserMessage("no disk")).begin_baud(9600, 4800).exception(0.0), "no disk"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_failure_says_in_the_log_what_it_is(error: Exception, text: str) -> None:
    assert str(error) == text


TWO_CHANGES = [SettingChange(BY_NAME["freefall_time"], 1.2), SettingChange(BY_NAME["attitude_threshold"], 70)]


@pytest.mark.parametrize(
    ("procedure", "doing", "total"),
    [
        (read_settings, "Reading: {what}", 6),
        (read_everything, "Reading: {what}", len(READABLE)),
        (lambda: look_for(57600, 38400), "Trying {rate} baud", 2 * ROUNDS + 4),
        (find_rate, "Trying {rate} baud", 6),
        (measure_light, "Measuring the light", 20),
        (lambda: write_all(TWO_CHANGES, WriteContext(journal=FakeJournal())), "Writing: {what}", 2),
    ],
)
def test_progress_is_counted_step_by_step(procedure: Callable[[], Procedure[object]], doing: str, total: int) -> None:
    rig, reports = Rig({"baud": 4800}, baud_rate=115200 if "rate" in doing else 4800), list[Report]()
    run = Run(procedure(), reports.append)
    rig.session.run(run)
    rig.step_until(lambda: run.is_done)
    steps = [(report.done, report.total) for report in reports if report.doing == doing]
    assert steps[:total] == [(done, total) for done in range(total)]


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
