"""A part of the walk and of the bad lines each time, another one each day; more of it where the tests are thorough."""

import datetime

import pytest

from app.preflight.verdict import Verdict
from protocol.events import EndReason
from tests.campaigns.walk import EXCHANGES, FAULTS, JOBS, LINES, Plan, Run, cells, odd_cells, walk, watched
from tests.support.line.module_line import Wear
from tests.support.processes import ROOT
from tests.support.thorough import IS_THOROUGH

TODAY = datetime.datetime.now(datetime.UTC).date().toordinal()
ROUNDS = 20 if IS_THOROUGH else 1
SECONDS = 3600.0 if IS_THOROUGH else 10.0


@pytest.mark.parametrize("job", JOBS)
@pytest.mark.promise("f", "i", "k")
def test_whatever_happens_a_job_ends_without_a_lie(job: str) -> None:
    plans = [
        plan
        for happenings, rounds in ((FAULTS, ROUNDS), (EXCHANGES, 4 * ROUNDS))
        for number in range(rounds)
        for plan in cells(job, happenings, seed=TODAY * rounds + number)
    ]
    results = list(walk(plans))
    assert [result for result in results if result.findings] == []
    assert all(result.has_happened for result in results)


@pytest.mark.parametrize("job", JOBS)
@pytest.mark.promise("f", "i")
def test_no_oddity_of_a_module_makes_a_job_lie(job: str) -> None:
    count = 20 * ROUNDS if "check" in job else 4 * ROUNDS
    plans = odd_cells(job, range(TODAY * count, (TODAY + 1) * count))
    assert [result for result in walk(plans) if result.findings] == []


def test_a_module_as_delivered_is_ready_and_go() -> None:
    """Without that the others would prove nothing."""
    assert [Run(Plan(job, "", -1)).go().verdict for job in ("check", "check and activate")] == [
        Verdict.READY,
        Verdict.GO,
    ]


def test_the_page_has_every_fault() -> None:
    page = (ROOT / "docs" / "internals" / "line-faults.md").read_text(encoding="utf-8")
    assert [name for name in FAULTS if f"\n| {name} |" not in page] == []


@pytest.mark.parametrize("name", LINES)
@pytest.mark.parametrize("streams", [False, True])
@pytest.mark.promise("k")
def test_no_conversation_ends_without_reason(name: str, *, streams: bool) -> None:
    found = watched(*LINES[name], SECONDS, streams=streams)
    assert (found.begins, found.ends) == (1, {})
    # Where a tenth of all frames is lost, one question in 20,000 is lost six times, and called not answered.
    assert found.unanswered <= (5 if name == "loses 10 %" else 0)


def test_on_a_line_that_is_dead_for_half_a_second_it_ends() -> None:
    assert watched(Wear(loss=0.9), 0.002, 20.0, streams=False).ends[EndReason.SILENT.name]


def test_a_port_that_is_lost_ends_everything_and_says_how() -> None:
    run = Run(Plan("read", "port lost", 3))
    assert run.go().findings == []
    assert run.job.has_ended
