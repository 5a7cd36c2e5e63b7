"""A part of `python -m tests.campaigns exchanges` each time, all of it where the tests are thorough."""

import pytest

from tests.campaigns.exchanges import JOBS, SILENCES_S, Plan, campaign, run
from tests.support.thorough import IS_THOROUGH

NOTICED_S = [silent_s for silent_s in SILENCES_S if silent_s >= 0.5]
STEPS = {"check": 131, "zero": 83, "write four": 41, "history": 37, "light": 37, "write one": 29}


@pytest.mark.parametrize("job", JOBS)
@pytest.mark.promise("f")
@pytest.mark.promise("i")
def test_from_half_a_second_on_no_exchange_is_missed_and_nothing_goes_on(job: str) -> None:
    silences_s = NOTICED_S if IS_THOROUGH else [0.5]
    step = 1 if IS_THOROUGH else STEPS.get(job, 5)
    results = list(campaign(step=step, jobs=[job], silences_s=silences_s))
    assert len(results) >= 2
    assert [result for result in results if result.findings] == []


def test_the_judge_sees_a_set_at_another_module() -> None:
    """A plug that is moved without any silence is not noticed before the next boot count."""
    plans = [Plan("write four", frame, 0.0, is_announced=False, streams=False) for frame in range(45)]
    assert any("a set of" in text for plan in plans for text in run(plan).findings)
