"""A part of `python -m tests.campaigns lines` each time: no conversation ends without reason."""

import pytest

from protocol.events import EndReason
from tests.campaigns.lines import LINES, BadLine, run
from tests.campaigns.plug import Wear
from tests.support.thorough import IS_THOROUGH

SECONDS = 3600.0 if IS_THOROUGH else 10.0


@pytest.mark.parametrize("name", LINES)
@pytest.mark.parametrize("streams", [False, True])
@pytest.mark.promise("k")
def test_no_conversation_ends_without_reason(name: str, *, streams: bool) -> None:
    found = run(LINES[name], SECONDS, streams=streams)
    assert (found.begins, found.ends) == (1, 0), found.reasons
    assert found.unanswered == 0


def test_on_a_line_that_is_dead_for_half_a_second_it_ends() -> None:
    found = run(BadLine(Wear(loss=0.9)), 20.0, streams=False)
    assert EndReason.SILENT.value in found.reasons
