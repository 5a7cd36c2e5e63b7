"""A light threshold by measurement, whichever way light moves the reading."""

import pytest

from app.engine.conversation import Interrupted
from app.procedures.light import (
    ENOUGH_SAMPLES,
    Band,
    CalibrationFault,
    LightDirection,
    Proposal,
    measure_light,
    propose,
)
from tests.support.line.frames import at_frame
from tests.support.line.sim_line import settled_rig


def band(low: int, high: int, count: int = ENOUGH_SAMPLES) -> Band:
    return Band(tuple(low if number % 2 else high for number in range(count)))


@pytest.mark.parametrize(("inverted", "direction"), [(False, LightDirection.RISES), (True, LightDirection.FALLS)])
def test_the_direction_is_found_and_the_threshold_lies_between(inverted: bool, direction: LightDirection) -> None:
    rig = settled_rig(light_inverted=inverted, noise=1.0)
    closed = rig.run(measure_light())
    rig.bench.set_world(bay_is_open=True)
    opened = rig.run(measure_light())
    proposal = propose(closed, opened)
    assert isinstance(proposal, Proposal)
    assert proposal.direction is direction
    assert len(closed.raws) == len(opened.raws) == 20
    low, high = sorted((closed, opened), key=lambda one: one.low_v)
    assert low.high_v < proposal.threshold_v < high.low_v
    assert proposal.margin_closed_v == pytest.approx(proposal.margin_open_v, abs=0.11)
    assert proposal.is_steady
    assert proposal.vendors_v == pytest.approx(0.3 if inverted else 2.5, abs=0.1)


@pytest.mark.parametrize(
    ("closed", "opened", "found"),
    [
        (band(3, 5), band(5, 9), CalibrationFault.TOO_CLOSE),
        (band(5, 9), band(3, 5), CalibrationFault.TOO_CLOSE),
        (band(3, 9), band(5, 6), CalibrationFault.TOO_CLOSE),
        (band(3, 5), band(6, 9), CalibrationFault.TOO_CLOSE),
        (band(6, 9), band(3, 5), CalibrationFault.TOO_CLOSE),
        (band(3, 5, 9), band(20, 21), CalibrationFault.TOO_FEW),
        (band(3, 5), band(20, 21, 9), CalibrationFault.TOO_FEW),
        (Band(()), Band(()), CalibrationFault.TOO_FEW),
    ],
)
def test_no_threshold_where_there_is_no_gap(closed: Band, opened: Band, found: CalibrationFault) -> None:
    assert propose(closed, opened) is found


@pytest.mark.parametrize(("closed", "opened"), [((3, 5), (7, 9)), ((7, 9), (3, 5)), ((0, 0), (255, 255))])
def test_the_smallest_gap_and_the_widest(closed: tuple[int, int], opened: tuple[int, int]) -> None:
    proposal = propose(band(*closed), band(*opened))
    assert isinstance(proposal, Proposal)
    assert min(proposal.margin_closed_v, proposal.margin_open_v) >= 0.1
    assert f"{proposal.threshold_v:.1f} V" in proposal.sentence


def test_light_that_is_not_steady_is_said() -> None:
    proposal = propose(band(0, 9), band(20, 21))
    assert isinstance(proposal, Proposal)
    assert not proposal.is_steady


def test_a_measurement_ends_where_nothing_answers() -> None:
    found = settled_rig(mute_codes=frozenset((0x14,))).run(measure_light())
    assert (found.raws, found.lost, found.is_enough) == ((), 10, False)


def test_a_restart_ends_the_measurement() -> None:
    rig = settled_rig()
    at_frame(rig.bench, 5, rig.bench.restart)
    with pytest.raises(Interrupted):
        rig.run(measure_light())


def test_a_band_of_light_at_its_limits() -> None:
    assert Band((5, 8)).is_steady
    assert not Band((5, 9)).is_steady
    assert not Band(()).is_steady
    assert Band((5,) * 10).is_enough
    assert not Band((5,) * 9).is_enough
    band = Band((5, 8, 6))
    assert (band.low_v, band.median_v, band.high_v) == (0.5, 0.6, 0.8)
