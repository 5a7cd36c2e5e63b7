"""What a check goes on with while the line loses frames."""

from collections.abc import Callable

import pytest

from app.preflight.evidence import HEARTBEATS, Disturbance, Evidence
from app.preflight.run import GIVE_UP_AFTER, run_preflight
from protocol.catalogue import HEARTBEAT, STATUS, Request
from protocol.frame import decode_request
from tests.support.line.sim_line import Rig


def lose(rig: Rig, is_lost: Callable[[int], bool], request: Request) -> None:
    """Loses each such request of which `is_lost` says so by its number."""
    write, count = rig.line.write, 0

    def filtered(data: bytes) -> None:
        nonlocal count
        if decode_request(data) == request:
            count += 1
            if is_lost(count):
                return
        write(data)

    rig.line.write = filtered  # type: ignore[method-assign]


@pytest.mark.parametrize(("answers_every", "disturbance"), [(8, None), (9, Disturbance.SILENT)])
def test_it_is_given_up_after_eight_unanswered_heartbeats_in_a_row(
    answers_every: int, disturbance: Disturbance | None
) -> None:
    rig, evidence = Rig(), Evidence(port="sim")
    assert GIVE_UP_AFTER == 4
    lose(rig, lambda number: number < HEARTBEATS and bool(number % answers_every), HEARTBEAT.query())
    rig.run(run_preflight(evidence))
    assert evidence.disturbance is disturbance


def test_the_last_status_counts_also_where_the_final_question_for_it_is_lost() -> None:
    rig, evidence = Rig(), Evidence(port="sim")
    rig.run(run_preflight(evidence))
    asked = rig.line.requests.count(STATUS.query())
    rig, evidence = Rig(), Evidence(port="sim")
    lose(rig, lambda number: number >= asked, STATUS.query())
    rig.run(run_preflight(evidence))
    assert evidence.last is not None
    assert evidence.last.status is None
    assert evidence.status is evidence.trials[-1]


def test_a_value_to_which_the_module_never_replies_is_named() -> None:
    rig, evidence = Rig({"mute_codes": "33"}), Evidence(port="sim")
    rig.run(run_preflight(evidence))
    assert {key: why.in_english() for key, why in evidence.faults.items()} == {"charging": "no reply"}
    assert "charging" not in evidence.series
