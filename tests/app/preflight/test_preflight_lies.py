"""A module that changes, restarts or falls silent while it is checked: the check that stands against it is named."""

from typing import NamedTuple

import pytest

from app.preflight.verdict import Verdict
from tests.support.line.sim_line import Rig
from tests.support.records.preflight_rig import Fault, assert_only_questions, check, on_request


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


def test_the_name_says_what_it_was_and_what_it_is() -> None:
    checked = check(options={"read_changes": "20:20=14@50"})
    finding = next(one.finding for one in checked.assessment.checks if one.check.id == "connection")
    assert finding.shown.in_english() == "Attitude threshold: 60°, then 20°. Two modules on this line?"


@pytest.mark.parametrize("code", [0x20, 0x21, 0x22, 0x15, 0x23])
@pytest.mark.promise("f")
def test_what_is_answered_once_only_is_unknown(code: int) -> None:
    """The setting is answered before the measuring and not after it."""

    def silence(rig: Rig) -> None:
        rig.bench.change(mute_codes=frozenset((code,)))

    checked = check(Fault(frozenset(), arrange=on_request(0x33, 1, silence)))
    assert checked.assessment.verdict is Verdict.NO_GO
    assert "read_twice" in checked.against
