"""The map over thresholds counts the outcomes of the flights; its curves and the judge agree."""

import math
from itertools import product

import numpy as np
import pytest

from app.flights.flight_log import FlightLog
from app.flights.judge import TriggerLimits
from app.flights.judging import NEVER, LossOfControl, RuleReading, firing_curves, loss_of_control, summarise
from app.flights.thresholds import TILTS_DEG, TIMES_S, FlightGroup, fire_map, outcome_of
from protocol.messages import Source
from tests.support.flights.made_flights import STEP_S, made_flight, plainly_judged, random_flight

ROWS = 500
TIMES = np.arange(ROWS) / 50
LOST_S, IMPACT_S, FROM_M = 3.0, 6.0, 45.0


def crash(name: str = "crash") -> FlightLog:
    """Tips over from 3.0 s on by 30° a second, falls from 3.5 s on, hits the ground at 6.0 s from 45 m."""
    tilt = np.clip(30 * (TIMES - LOST_S), 0, 88)
    force = np.select([TIMES < 3.5, TIMES < IMPACT_S, TIMES < IMPACT_S + 0.06], [1.0, 0.2, 12.0], 1.0)
    altitude = FROM_M - 5 * np.clip(TIMES - LOST_S, 0, IMPACT_S - LOST_S) ** 2
    return made_flight(tilt, force, name=name, altitude_m=altitude)


def test_the_map_counts_the_outcome_of_each_flight() -> None:
    random = np.random.default_rng(5)
    must_not, must = ([summarise(random_flight(random)) for _ in range(7)] for _ in range(2))
    must.append(summarise(crash()))
    cells = list(product((0, 15, 30, 60, len(TILTS_DEG) - 1), (0, 16, 28, len(TIMES_S) - 1)))
    for reading in RuleReading:
        for limits in (
            TriggerLimits(),
            TriggerLimits(freefall_acceleration_g=0.3, attitude_is_enabled=False),
            TriggerLimits(freefall_acceleration_g=1.5, freefall_is_enabled=False),
        ):
            found = fire_map(must_not, must, limits, reading)
            assert (found.must_not_count, found.must_count) == (7, 8)
            for row, column in cells:
                at = limits._replace(attitude_threshold_deg=TILTS_DEG[row], freefall_time_s=TIMES_S[column])
                fired = sum(bool(flight.first_fire(at, reading).sources) for flight in must_not)
                assert found.must_not_fired[row, column] == fired
                assert found.must_fired[row, column] == sum(
                    flight.first_fire(at, reading).is_in_time for flight in must
                )


def test_how_late_it_fires() -> None:
    flight = summarise(crash())
    assert flight.loss_s == pytest.approx(3.48)  # the last row of weight, at a tilt below 30°
    assert flight.impact_s == IMPACT_S
    fire = flight.first_fire(TriggerLimits())
    assert (fire.at_s, fire.sources, fire.is_in_time) == (5.0, Source.ATTITUDE, True)
    assert fire.delay_s == pytest.approx(5.0 - 3.48)
    never = flight.first_fire(TriggerLimits(attitude_threshold_deg=89, freefall_time_s=2.55))
    assert (never.at_s, never.is_in_time) == (math.inf, False)
    fell = flight.first_fire(TriggerLimits(attitude_is_enabled=False))
    assert (fell.at_s, fell.sources) == (pytest.approx(3.5 + 1.6), Source.FREEFALL)


def test_a_firing_after_the_impact_is_not_in_time() -> None:
    log = crash()
    log.tilt_deg[TIMES > IMPACT_S] = 120.0
    fire = summarise(log).first_fire(TriggerLimits(attitude_threshold_deg=100, freefall_is_enabled=False))
    assert (fire.at_s, fire.is_in_time) == (pytest.approx(IMPACT_S + 0.02), False)


def test_outcomes_show_where_the_readings_differ() -> None:
    tilt = np.zeros(ROWS)
    tilt[100:104] = 75
    flights = [summarise(made_flight(tilt, 1.0, name="bump")), summarise(crash())]
    bump, fell = (outcome_of(flight, FlightGroup.MUST, TriggerLimits()) for flight in flights)
    assert (bump.is_different, bool(bump.direct.sources), bool(bump.damped.sources)) == (True, True, False)
    assert not fell.is_different


def shaken(*rows: int, force_g: float = 5.0) -> np.ndarray:
    force = np.ones(ROWS)
    force[list(rows)] = force_g
    return force


TIPS_OVER = np.where(TIMES >= 4, 70.0, 0.0)
LOSSES = {
    "calm to its end": (made_flight(np.full(ROWS, 5.0), 1.0), None, None),
    "empty": (made_flight(np.full(0, 5.0), np.ones(0)), None, None),
    "a hard landing": (made_flight(5.0, shaken(400, force_g=4.0)), None, 8.0),
    "shocks, then calm, then it tips over until the end": (
        made_flight(np.where(TIMES >= 6, 80.0, 0.0), shaken(*range(100, 125), force_g=4.0)), 5.98, None,
    ),
    "shocks close together are one impact": (made_flight(TIPS_OVER, shaken(100, 250, 280, 340)), 3.98, 5.0),
}  # fmt: skip


@pytest.mark.parametrize("case", LOSSES)
def test_when_control_was_lost_and_it_hit_the_ground(case: str) -> None:
    log, loss_s, impact_s = LOSSES[case]
    lost = loss_of_control(log)
    assert (lost.loss_s is None, lost.impact_s) == (loss_s is None, impact_s)
    if loss_s is not None:
        assert lost.loss_s == pytest.approx(loss_s)


@pytest.mark.parametrize("has_peaks", [True, False])
def test_what_moves_the_wreck_is_no_loss_of_control(has_peaks: bool) -> None:
    """It flips, crashes and lies level for a while, then somebody picks it up and drops it."""
    tilt = np.select([TIMES < LOST_S, TIMES < IMPACT_S, TIMES < 9.0], [0.0, 120.0, 5.0], 80.0)
    force = np.select([TIMES < LOST_S, TIMES < IMPACT_S, TIMES < IMPACT_S + 0.06], [1.0, 0.2, 12.0], 1.0)
    force[470] = 5.0
    altitude = FROM_M - 5 * np.clip(TIMES - LOST_S, 0, IMPACT_S - LOST_S) ** 2
    if not has_peaks:
        force = np.minimum(force, 2.0)
    lost = loss_of_control(made_flight(tilt, force, altitude_m=altitude))
    assert lost == LossOfControl(pytest.approx(LOST_S, abs=0.03), pytest.approx(IMPACT_S, abs=0.1))  # type: ignore[arg-type]


def test_a_flip_that_it_flew_on_from_is_not_said_to_be_before_a_loss() -> None:
    tilt = np.select([TIMES < 2.0, TIMES < 2.5, TIMES < 8.0], [0.0, 150.0, 5.0], 90.0)
    flight = summarise(made_flight(tilt, 1.0))
    assert flight.first_fire(TriggerLimits()).late_text == "then calm again until 8.0 s"
    assert flight.loss_s == pytest.approx(7.98)


@pytest.mark.parametrize("reading", RuleReading)
@pytest.mark.promise("g")
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
            judged = plainly_judged(log, limits, reading)
            assert curves.first(limits) == (judged[0] if judged else (NEVER, Source(0)))
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


def test_the_first_firing_of_each_trigger_is_told() -> None:
    tilt, force = np.full(300, 5.0), np.ones(300)
    tilt[200:] = 61.4
    force[50:160] = 0.33
    curves = firing_curves(made_flight(tilt, force), RuleReading.DIRECT)
    assert curves.firings(TriggerLimits()) == [
        (pytest.approx(2.6), Source.FREEFALL, 5),
        (4.0, Source.ATTITUDE, 61),
    ]
    assert curves.firings(TriggerLimits(attitude_threshold_deg=62, freefall_time_s=2.5)) == []


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
