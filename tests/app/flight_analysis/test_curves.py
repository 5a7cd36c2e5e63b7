"""The curves agree with the judge for all thresholds."""

import numpy as np
import pytest

from app.firing.judge import TriggerLimits
from app.flight_analysis.curves import NEVER, firing_curves
from app.flight_analysis.judged_flight import judge_flight
from app.flight_logs.module_view import RuleReading
from protocol.messages import Source
from tests.support.flights.made_flights import STEP_S, made_flight, random_flight


@pytest.mark.parametrize("reading", RuleReading)
def test_the_curves_agree_with_the_judge(reading: RuleReading) -> None:
    random = np.random.default_rng(14)
    fired = 0
    for _ in range(60):
        log = random_flight(random)
        curves = firing_curves(log, reading)
        for _ in range(5):
            limits = TriggerLimits(
                attitude_threshold_deg=int(random.integers(0, 200)),
                freefall_acceleration_g=int(random.integers(0, 16)) / 10,
                freefall_time_s=int(random.integers(0, 256)) / 100,
                attitude_is_enabled=bool(random.random() < 0.6),
                freefall_is_enabled=bool(random.random() < 0.8),
            )
            judged = judge_flight(log, limits, reading).firings
            at_s, sources = curves.first(limits)
            assert (at_s, sources) == ((judged[0].at_s, judged[0].sources) if judged else (NEVER, Source(0)))
            fired += bool(judged)
    assert 60 < fired < 280


def test_exact_times() -> None:
    tilt = np.zeros(300)
    tilt[100:] = 61.4
    force = np.ones(300)
    force[50:131] = 0.449
    curves = firing_curves(made_flight(tilt, force), RuleReading.DIRECT)
    assert curves.attitude_s[61] == 2.0
    assert curves.attitude_s[62] == NEVER
    assert curves.longest_fall_s[5] == pytest.approx(1.6)
    assert curves.freefall_s[5, 160] == pytest.approx(2.6)
    assert curves.freefall_s[5, 161] == NEVER
    assert curves.freefall_s[4, 0] == NEVER  # 0.449 g is reported as 0.4 g, which is not below 0.4 g
    assert curves.longest_fall_s[4] == -1
    with pytest.raises(LookupError):
        curves.first(TriggerLimits(freefall_acceleration_g=1.6))


def test_damped_requires_an_angle_to_last() -> None:
    tilt = np.zeros(200)
    tilt[50:60] = 80.0  # ten rows: 0.18 s
    assert firing_curves(made_flight(tilt, 1.0), RuleReading.DIRECT).attitude_s[60] == 1.0
    assert firing_curves(made_flight(tilt, 1.0), RuleReading.DAMPED).attitude_s[60] == NEVER
    tilt[50:61] = 80.0
    assert firing_curves(made_flight(tilt, 1.0), RuleReading.DAMPED).attitude_s[60] == pytest.approx(1.2)


def test_damped_ignores_a_spike_in_a_fall() -> None:
    force = np.ones(300)
    force[50:250] = 0.1
    force[120] = 1.2
    direct = firing_curves(made_flight(0.0, force), RuleReading.DIRECT)
    damped = firing_curves(made_flight(0.0, force), RuleReading.DAMPED)
    assert direct.longest_fall_s[5] == pytest.approx(129 * STEP_S - STEP_S)
    assert damped.longest_fall_s[5] > 3.7
