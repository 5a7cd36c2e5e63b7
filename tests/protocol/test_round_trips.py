"""How long the answer to a question is waited for."""

import pytest

from protocol.round_trips import ENOUGH_SAMPLES, RoundTrips, Timing

TIMING = Timing(answer_s=1.0, shortest_wait_s=0.125, attempts=4)


def measured(*samples_s: float) -> RoundTrips:
    round_trips = RoundTrips()
    for sample_s in samples_s:
        round_trips.add(sample_s)
    return round_trips


def test_the_vendors_numbers() -> None:
    timing = Timing()
    assert (timing.answer_s, timing.attempts) == (1.0, 3)
    assert timing.late_s == timing.attempts * timing.answer_s
    assert 10.0 <= timing.heartbeat_every_s <= 30.0
    assert timing.doubled_s < 0.05 < timing.restart_s < 1.0, "a restart sends two heartbeats 50 ms apart"
    assert timing.drain_s + timing.probe_after_s < timing.shortest_wait_s < timing.quiet_s < timing.records_quiet_s


@pytest.mark.parametrize(
    ("samples_s", "waits_s"),
    [
        ([], (1.0, 1.0, 1.0, 1.0)),
        ([0.0625] * (ENOUGH_SAMPLES - 1), (0.5, 1.0, 1.0, 1.0)),
        ([0.0625] * ENOUGH_SAMPLES, (0.25, 0.5, 1.0, 1.0)),
        ([0.0] * ENOUGH_SAMPLES, (0.125, 0.25, 0.5, 1.0)),
        ([2.0] * ENOUGH_SAMPLES, (1.0, 1.0, 1.0, 1.0)),
        ([0.0] * 95 + [0.0625] * 5, (0.25, 0.5, 1.0, 1.0)),
        ([0.0] * 96 + [0.0625] * 4, (0.125, 0.25, 0.5, 1.0)),
    ],
)
def test_the_waits_grow_from_the_measured_round_trips(samples_s: list[float], waits_s: tuple[float, ...]) -> None:
    assert measured(*samples_s).waits_s(TIMING) == waits_s


def test_quantiles_of_the_latest_samples() -> None:
    assert (measured().minimum_s, measured().median_s) == (None, None)
    three = measured(3.0, 1.0, 2.0)
    assert (len(three), three.minimum_s, three.median_s) == (3, 1.0, 2.0)
    three.add(0.5)
    assert (three.minimum_s, three.median_s, three.quantile_s(0.75)) == (0.5, 2.0, 3.0)
    last_two = RoundTrips(kept=2)
    for sample_s in (1.0, 3.0, 2.0):
        last_two.add(sample_s)
    assert (len(last_two), last_two.minimum_s) == (2, 2.0)
