"""A light threshold by measurement, whichever way light moves the reading."""

import pytest

from app.procedures.light import (
    ENOUGH_SAMPLES,
    Band,
    CalibrationFault,
    LightDirection,
    Proposal,
    measure_light,
    propose,
)
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
