"""The guided tests on the simulated module, with hands that do what they are told, and with some that do not."""

import re
from collections.abc import Callable
from typing import Any

import pytest

from app.engine.conversation import reason_message
from app.engine.procedure import Report
from app.flights.judge import TriggerLimits
from app.guided import guided_tests
from app.guided.guided_tests import DIRECTIONS, GUIDED_TESTS, LOOSE_ENDS, PersonSteps, judge_bay, measure_link
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict
from app.procedures.light import Band
from app.procedures.stream import StreamSwitch, watch
from app.simulator import module as simulator_module
from app.text.messages import UserError
from protocol.catalogue import Hazard
from protocol.events import EndReason
from protocol.messages import Source
from tests.support.line.sim_line import Rig, settled_rig
from tests.unit.guided.hands import SLOWLY_DEG_S, Hands, guided

KINDS = [test.kind for test in GUIDED_TESTS]


def streaming(attitude_threshold: int | None = None, **options: object) -> Rig:
    """A module that streams its status, as while the page is in sight."""
    switch = StreamSwitch()
    rig = Rig(options, background=lambda: watch(switch))
    if attitude_threshold is not None:
        rig.bench.module.memory.attitude_threshold = attitude_threshold
    rig.step_for(4.0)
    return rig


def result(done: GuidedResult | UserError) -> GuidedResult:
    assert isinstance(done, GuidedResult), done
    return done


def reason(done: GuidedResult | UserError) -> str:
    assert isinstance(done, UserError), done
    return done.message.in_english()


def rows(done: GuidedResult | UserError) -> dict[str, tuple[str, str]]:
    return {one.name.in_english(): (one.shown.in_english(), one.verdict.value) for one in result(done).measured}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("is_streaming", [True, False])
def test_a_module_in_order_passes(kind: GuidedKind, is_streaming: bool) -> None:
    rig = streaming(rate=50) if is_streaming else settled_rig()
    sent = len(rig.line.requests)
    done = result(guided(rig, kind))
    assert done.verdict is GuidedVerdict.PASSED, [one.shown.in_english() for one in done.measured]
    assert done.kind is kind
    assert all(request.hazard is Hazard.NONE for request in rig.line.requests[sent:])


@pytest.mark.promise("f")
def test_the_angle_at_which_it_fired_and_rearmed_is_measured_in_four_directions() -> None:
    rig = streaming(attitude_threshold=70, rate=50)
    before = len(rig.bench.module.memory.records)
    done = result(guided(rig, GuidedKind.TILT))
    spans = [re.findall(r"\d+", one.shown.in_english()) for one in done.measured]
    assert len(spans) == 8
    assert all(abs(int(angles[-1]) - 70) <= 1 for angles in spans[::2])
    assert all(abs(int(angles[0]) - 60) <= 1 for angles in spans[1::2])
    assert len(rig.bench.module.memory.records) - before == 4


@pytest.mark.promise("f")
def test_a_module_that_fires_ten_degrees_later_than_it_was_set_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    def limits(attitude_threshold_deg: float, **others: Any) -> TriggerLimits:
        return TriggerLimits(attitude_threshold_deg=attitude_threshold_deg + 10, **others)

    monkeypatch.setattr(simulator_module, "TriggerLimits", limits)
    done = result(guided(streaming(rate=50), GuidedKind.TILT))
    assert done.verdict is GuidedVerdict.FAILED
    assert rows(done)["Fires, forward"][1] == "failed"


@pytest.mark.promise("f")
def test_moved_too_fast_it_is_done_again_and_stays_unclear(monkeypatch: pytest.MonkeyPatch) -> None:
    said, hear = list[str](), Hands.hear

    def listen(hands: Hands, report: Report) -> None:
        said.append(report.doing)
        hear(hands, report)

    monkeypatch.setattr(Hands, "hear", listen)
    rig = streaming(rate=5)
    done = result(guided(rig, GuidedKind.TILT, speed_deg_s=900.0))
    assert done.verdict is GuidedVerdict.UNCLEAR
    assert rows(done)["Fires, forward"][1] == "unclear"
    assert said.index("Hold it level.") < said.index("Too fast. Hold it level.")
    tilts = [text for text in said if "until it fires" in text]
    assert ["Too fast" in text for text in tilts[:4]] == [False, True, True, False], (
        "level again, it may be said at once"
    )
    named = [text for text in said for direction in DIRECTIONS if direction in text]
    assert not named, "else what to do after it fired reads as the direction"


@pytest.mark.parametrize("fast", ["ilt it slowly", "It fired"])
@pytest.mark.promise("f")
def test_one_way_that_is_too_fast_is_enough(fast: str) -> None:
    class Uneven(Hands):
        def hear(self, report: Report) -> None:
            super().hear(report)
            self.speed_deg_s = 900.0 if fast in report.doing else SLOWLY_DEG_S

    done = result(guided(streaming(rate=5), GuidedKind.TILT, hands=Uneven))
    assert rows(done)["Fires, forward"][1] == "unclear"


def test_a_disabled_trigger_does_not_fire_and_fails() -> None:
    rig = streaming()
    rig.bench.module.state.attitude_is_enabled = False
    done = result(guided(rig, GuidedKind.TILT))
    assert done.verdict is GuidedVerdict.FAILED
    assert rows(done)["Fires, forward"][0].startswith("not up to 8")
    assert done.advice is not None


def test_a_module_that_stays_triggered_fails_and_is_not_tilted_further(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = streaming()
    module = rig.bench.module
    sense = module._sense

    def sense_and_stay(at_s: float) -> None:
        before = module._fired
        sense(at_s)
        module._fired |= before

    monkeypatch.setattr(module, "_sense", sense_and_stay)
    done = result(guided(rig, GuidedKind.TILT))
    assert rows(done)["Rearms, forward"] == ("no", "failed")
    assert "Fires, left" not in rows(done)
    assert len(module.memory.records) == 1


@pytest.mark.parametrize(("height_m", "verdict"), [(0.3, "passed"), (1.0, "passed"), (5.0, "failed")])
@pytest.mark.promise("f")
def test_the_fall_is_measured(height_m: float, verdict: str) -> None:
    rig = streaming(rate=50)
    done = result(guided(rig, GuidedKind.FREE_FALL, height_m=height_m))
    seconds = (2 * height_m / 9.81) ** 0.5
    first = done.measured[0]
    assert float(first.shown.in_english().removesuffix(" s")) == pytest.approx(seconds, abs=0.04)
    assert first.verdict.value == verdict
    assert rows(done)["Trigger"] == ("not triggered", "passed")


def test_a_jerk_is_no_fall() -> None:
    class Jerky(Hands):
        jerked_at = -1.0

        def hear(self, report: Report) -> None:
            self.height_m = 0.01
            super().hear(report)

        def move(self, now: float) -> None:
            super().move(now)
            if self.jerked_at < 0 and self.said[-1:] == ["Let it fall"]:
                self.jerked_at = now
            elif self.height_m < 0.5 and 0 < self.jerked_at < now - 1.0:
                self.height_m = 0.5
                self.bench.drop(self.height_m)

    done = result(guided(streaming(rate=50), GuidedKind.FREE_FALL, hands=Jerky))
    assert done.verdict is GuidedVerdict.PASSED


@pytest.mark.parametrize(
    ("threshold", "open_row"), [(18, "passed"), (30, "failed"), (25, "failed"), (24, "passed"), (2, "passed")]
)
def test_the_light_and_its_margin(threshold: int, open_row: str) -> None:
    rig = settled_rig()
    rig.bench.module.memory.light_threshold = threshold
    done = guided(rig, GuidedKind.BAY)
    assert rows(done)["Bay open"][1] == open_row
    assert rows(done)["Bay closed"][1] == ("failed" if threshold == 2 else "passed")


@pytest.mark.promise("f")
def test_the_light_that_is_nearest_to_the_threshold_decides() -> None:
    """Of each position one reading strays to the threshold, at either sense of the sensor."""
    dark, bright = Band((3, 3, 18)), Band((30, 30, 18))
    for closed, opened in ((dark, Band((30,))), (Band((3,)), bright), (bright, Band((3,))), (Band((30,)), dark)):
        assert judge_bay(closed, opened, 1.8).verdict is GuidedVerdict.FAILED
    assert judge_bay(Band((3,)), Band((30,)), 1.8).verdict is GuidedVerdict.PASSED


def test_a_plug_that_loses_answers_fails() -> None:
    rig = settled_rig()
    start = rig.clock.now_s

    def shake() -> None:
        if start + 8 < rig.clock.now_s < start + 8.1:
            rig.bench.change(drop=0.5)
        elif rig.clock.now_s > start + 10:
            rig.bench.change(drop=0.0)

    assert rows(guided(rig, GuidedKind.LINK, each=shake))["Lost replies"][1] == "failed"


LOOSE: dict[EndReason, Callable[[Rig], object]] = {
    EndReason.PORT_LOST: lambda rig: rig.session.close(EndReason.PORT_LOST),
    EndReason.RESTARTED: lambda rig: rig.bench.restart(),
    EndReason.SILENT: lambda rig: rig.bench.change(mute=True),
}


@pytest.mark.parametrize("at_s", [1.0, 6.0])
@pytest.mark.parametrize("reason", LOOSE, ids=lambda reason: reason.name)
@pytest.mark.promise("f")
def test_what_a_loose_plug_does_to_the_conversation_is_its_result(reason: EndReason, at_s: float) -> None:
    rig = settled_rig()
    job = rig.job(measure_link(PersonSteps()), expects=LOOSE_ENDS)
    rig.step_for(at_s)
    LOOSE[reason](rig)
    if not rig.line.is_closed:
        rig.step_until(lambda: job.has_ended, limit_s=3.0)
    done = job.outcome()
    assert done.verdict is GuidedVerdict.FAILED
    shown, verdict = rows(done)["Interruption"]
    ended = rig.conversation.ended
    assert verdict == "failed"
    assert ended is None or shown == reason_message(ended.reason, ended.contradiction).in_english()


@pytest.mark.parametrize("kind", KINDS)
def test_an_active_module_is_not_tested(kind: GuidedKind) -> None:
    rig = settled_rig(active=True)
    assert reason(guided(rig, kind)) == "The module is ACTIVE: lock it first."
    rig.bench.module.activate(is_active=False)
    rig.bench.module._fired = Source.PWM
    rig.step_for(0.5)
    assert reason(guided(rig, kind)) == "The module reports that it has fired."
    assert all(request.hazard is Hazard.NONE for request in rig.line.requests)


@pytest.mark.parametrize("kind", KINDS[1:])
@pytest.mark.promise("f")
def test_a_module_that_becomes_active_meanwhile_breaks_it_off(kind: GuidedKind) -> None:
    rig = settled_rig()
    done = guided(rig, kind, act=lambda: rig.bench.module.activate(is_active=True))
    assert "ACTIVE" in reason(done)


class Idle(Hands):
    """Does nothing to the module."""

    def hear(self, report: Report) -> None:
        self.said.append(report.doing)

    def move(self, now: float) -> None:
        """Nothing."""


class Hasty(Idle):
    """And confirms each step at once."""

    def move(self, now: float) -> None:
        self.steps.confirm()


@pytest.mark.parametrize(
    ("kind", "hands"),
    [*((kind, Idle) for kind in KINDS), (GuidedKind.TILT, Hasty), (GuidedKind.FREE_FALL, Hasty)],
)
@pytest.mark.promise("f")
def test_where_nothing_happens_it_says_that_it_cannot_tell(
    kind: GuidedKind, hands: type[Hands], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(guided_tests, "PERSON_LIMIT_S", 6.0)
    assert reason(guided(settled_rig(), kind, hands=hands)) == "No step within 6 s."


@pytest.mark.parametrize("options", [{}, {"bay_open": True}])
@pytest.mark.promise("f")
def test_a_bay_that_was_not_opened_fails(options: dict[str, object]) -> None:
    done = result(guided(settled_rig(**options), GuidedKind.BAY, hands=Hasty))
    assert done.verdict is GuidedVerdict.FAILED
    assert done.advice is not None
    assert done.advice.in_english() == "Measure the light threshold."
