"""A module that changes, restarts or falls silent while it is checked: the check that stands against it is named."""

from typing import NamedTuple

import pytest

from app.preflight.verdict import Verdict
from tests.support.records.preflight_rig import assert_only_questions, check


class Lie(NamedTuple):
    """`named`: the check that stands against it."""

    options: dict[str, str]
    named: str


LIES = {
    "threshold moves 50 ms after it was read": Lie({"read_changes": "20:20=14@50"}, "read_twice"),
    "threshold moves 500 ms after it was read": Lie({"read_changes": "20:20=14@500"}, "read_twice"),
    "free-fall time moves when the light is read": Lie({"read_changes": "14:22=05"}, "read_twice"),
    "enabling a trigger moves the threshold": Lie({"cross_talk": "16:20=14"}, "connection"),
    "the same, half a second later": Lie({"cross_talk": "17:20=14@500"}, "read_twice"),
    "to a value that the advice allows": Lie({"cross_talk": "17:20=50@500"}, "read_twice"),
    "restarts silently after a trigger was enabled": Lie({"silent_restart_ms": "30"}, "attitude_trigger"),
    "restarts silently while it is measured": Lie({"uptime": "0", "restart_at_s": "3"}, "connection"),
}


@pytest.mark.parametrize("name", LIES)
@pytest.mark.promise("f")
def test_what_moves_is_named(name: str) -> None:
    lie = LIES[name]
    checked = check(options=lie.options)
    assert checked.assessment.verdict is Verdict.NO_GO
    assert lie.named in checked.against
    assert_only_questions(checked)
