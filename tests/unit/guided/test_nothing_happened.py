"""Guided tests and the light calibration: nothing happened, all was constant, each step was confirmed at once."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import pytest

from app.engine.procedure import Report
from app.guided import guided_tests
from app.guided.guided_tests import GUIDED_BY_KIND, PersonSteps
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict
from app.procedures.light import CalibrationFault
from app.text.messages import UserError
from tests.support.hands import Hands, drive
from tests.support.line.sim_line import Rig, settled_rig

FAILED = GuidedVerdict.FAILED
ALIKE = CalibrationFault.TOO_CLOSE.value
NO_STEP = "No step within 6 s."


class Idle(Hands):
    """Does nothing to the module; confirms each step at once if `presses`."""

    presses = False

    def hear(self, report: Report) -> None:
        self.said.append(report.doing)

    def move(self, now: float) -> None:
        if self.presses:
            self.steps.confirm()


def idle(rig: Rig, kind: GuidedKind, *, presses: bool) -> GuidedResult | UserError:
    test, steps = GUIDED_BY_KIND[kind], PersonSteps()
    hands = Idle(rig.bench, steps)
    hands.presses = presses
    try:
        measure = drive(rig, test.prepare(), hands)
        if test.is_active:
            rig.bench.module.activate(is_active=True)
            rig.step_for(0.1)
        return drive(rig, measure(steps), hands)
    except UserError as why:
        return why


class Case(NamedTuple):
    """`said`: the reason of a test that was broken off, or the advice beside a result."""

    kind: GuidedKind
    presses: bool
    verdict: GuidedVerdict | None
    said: str | None
    options: Mapping[str, object] = MappingProxyType({})


CASES = (
    Case(GuidedKind.TILT, False, None, NO_STEP),
    Case(GuidedKind.TILT, True, None, NO_STEP),
    Case(GuidedKind.FREE_FALL, False, None, NO_STEP),
    Case(GuidedKind.FREE_FALL, True, None, NO_STEP),
    Case(GuidedKind.BAY, False, None, NO_STEP),
    Case(GuidedKind.BAY, True, FAILED, ALIKE),
    Case(GuidedKind.BAY, True, FAILED, ALIKE, {"bay_open": True, "light_inverted": True}),
    Case(GuidedKind.LINK, False, None, NO_STEP),
)


@pytest.mark.parametrize("case", CASES, ids=str)
@pytest.mark.promise("f")
def test_it_fails_or_says_that_it_cannot_tell(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guided_tests, "PERSON_LIMIT_S", 6.0)
    done = idle(settled_rig(**case.options), case.kind, presses=case.presses)
    if isinstance(done, UserError):
        assert case.verdict is None
        assert case.said is not None
        assert done.message.in_english() == case.said
    else:
        advice = None if done.advice is None else done.advice.in_english()
        assert (done.verdict, advice) == (case.verdict, case.said)


@pytest.mark.parametrize("raw", [0, 9, 12, 255])
def test_a_fall_is_not_tested_where_rest_counts_as_falling(raw: int) -> None:
    rig = settled_rig()
    rig.bench.module.memory.freefall_acceleration = raw
    done = idle(rig, GuidedKind.FREE_FALL, presses=False)
    assert isinstance(done, UserError)
    assert done.message.in_english().endswith("rest and fall cannot be told apart.")
