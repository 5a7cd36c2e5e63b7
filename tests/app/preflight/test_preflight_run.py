"""What a check goes on with while the line loses frames; its verdict outlives neither a sleep nor a silence."""

import itertools
from collections.abc import Callable

import pytest

from app.engine.device import How, Known
from app.engine.procedure import Cancelled, PortLost
from app.engine.session import Session
from app.limits.past import Past
from app.preflight.evidence import HEARTBEATS, Disturbance, Evidence
from app.preflight.findings import Case
from app.preflight.run import GIVE_UP_AFTER, run_preflight
from app.preflight.verdict import Assessment, assess, void_reason
from app.settings.profiles import NO_PROFILE
from app.system.sleep_detector import SleepDetector
from protocol.catalogue import HEARTBEAT, STATUS, Request
from tests.support.line.frames import at_each_frame
from tests.support.line.sim_line import INSTANT_S, Rig


def lose(rig: Rig, is_lost: Callable[[int], bool], request: Request) -> None:
    """Loses each such request of which `is_lost` says so by its number."""
    numbers = itertools.count(1)
    at_each_frame(rig.bench, lambda sent: not (sent == request and is_lost(next(numbers))))


@pytest.mark.parametrize(("answers_every", "disturbance"), [(8, None), (9, Disturbance.SILENT)])
def test_it_is_given_up_after_eight_unanswered_heartbeats_in_a_row(
    answers_every: int, disturbance: Disturbance | None
) -> None:
    rig, evidence = Rig(), Evidence(port="sim")
    assert GIVE_UP_AFTER == 4
    lose(rig, lambda number: number < HEARTBEATS and bool(number % answers_every), HEARTBEAT.query())
    rig.run(run_preflight(evidence))
    assert evidence.disturbance is disturbance


def test_a_status_before_a_silence_is_not_said_of_what_answers_then() -> None:
    """The final question for it is lost, and so long a silence may be an exchange."""
    rig, evidence = Rig(), Evidence(port="sim")
    rig.run(run_preflight(evidence))
    asked = rig.line.requests.count(STATUS.query())
    rig, evidence = Rig(), Evidence(port="sim")
    lose(rig, lambda number: number >= asked, STATUS.query())
    rig.run(run_preflight(evidence))
    assert evidence.last is not None
    assert evidence.disturbance is Disturbance.BROKEN
    assert (evidence.last.status, evidence.status, evidence.trials) == (None, None, [])


def test_a_value_to_which_the_module_never_replies_is_named() -> None:
    rig, evidence = Rig({"mute_codes": "33"}), Evidence(port="sim")
    rig.run(run_preflight(evidence))
    assert {key: why.in_english() for key, why in evidence.faults.items()} == {"charging": "no reply"}
    assert "charging" not in evidence.series


# After the check


NIGHT_S = 8 * 3600.0


class NightRig(Rig):
    """A rig on a computer whose other clock goes on while `asleep_s` grows."""

    def __init__(self) -> None:
        super().__init__({"uptime": 60, "noise": 0})
        self.asleep_s = 0.0
        watch = SleepDetector(self.clock, lambda: self.clock.now_s + self.asleep_s)
        self.session = Session(self.line, self.clock, asleep_s=watch.poll)
        self.clock.now_s += INSTANT_S

    def checked(self) -> Assessment:
        evidence = Evidence(port="sim")
        self.run(run_preflight(evidence, is_enabling=True))
        assert evidence.is_complete
        return assess(Case(evidence=evidence, profile=NO_PROFILE, past=Past()))


MINIMUM_V = NO_PROFILE.limit("cell_voltage_min_v")


@pytest.mark.parametrize(
    ("key", "value", "reason"),
    [
        ("light_v", 1.7, None),
        ("light_v", 1.8, Disturbance.CHANGED),
        ("cell_voltage_v", MINIMUM_V, None),
        ("cell_voltage_v", MINIMUM_V - 0.02, Disturbance.CHANGED),
    ],
)
def test_an_opened_bay_or_a_low_cell_voids(key: str, value: float, reason: Disturbance | None) -> None:
    rig = NightRig()
    assessment = rig.checked()
    assert assessment.case.evidence.values["light_threshold_v"] == 1.8
    now = rig.clock.now_s
    view = rig.session.device.view(now)
    changed = view._replace(values={**view.values, key: Known(value, How.READ, now)})
    found = void_reason(assessment, changed, now, opened_at=rig.session.opened_at)
    assert (None if found is None else found.reason) is reason


@pytest.mark.parametrize(
    ("end", "disturbance"), [(PortLost(), Disturbance.DISCONNECTED), (Cancelled(), Disturbance.INTERRUPTED)]
)
def test_a_check_that_ends_early_has_no_result(end: Exception, disturbance: Disturbance) -> None:
    rig, evidence = NightRig(), Evidence(port="sim")
    run = rig.started(run_preflight(evidence))
    rig.step_for(1.0)
    rig.session.close(why=end)
    assert (run.result, type(run.error)) == (None, type(end))
    assert evidence.disturbance is disturbance
