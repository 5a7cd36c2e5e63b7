"""The fingerprint of the settings, and the comparison of a profile with a module."""

from types import MappingProxyType

import pytest

from app.engine.conversation import ConversationView, How, Known
from app.settings.form import Match, compare
from app.settings.profiles import Profile
from app.settings.values import fingerprint
from protocol.catalogue import READABLE_SETTINGS
from protocol.events import Ended, EndReason
from protocol.fields import Value

USUAL: dict[str, Value] = {
    "light_threshold_v": 1.8,
    "attitude_threshold_deg": 60,
    "freefall_acceleration_g": 0.5,
    "freefall_time_s": 1.6,
}


def code(**changed: Value) -> str:
    found = fingerprint({**USUAL, **changed})
    assert found is not None
    return found


def test_only_the_covered_settings_decide_the_code() -> None:
    assert code() == "OPQ7-5ZRY", "printed on stickers: it never changes between versions"
    assert code() == code(freefall_time_s=1.60, attitude_threshold_deg=60.0)
    assert code() == code(attitude_trigger=True, serial_output=False, baud_rate=9600)


def test_every_setting_changes_the_code_and_without_one_there_is_none() -> None:
    codes = {code()}
    for command in READABLE_SETTINGS:
        assert command.write is not None
        for raw in range(256):
            codes.add(code(**{command.key: command.write.decode(raw)}))
    assert len(codes) == 1 + 4 * 255
    for missing in USUAL:
        assert fingerprint({key: value for key, value in USUAL.items() if key != missing}) is None


@pytest.mark.parametrize(
    ("known", "ended", "match"),
    [
        (Known(1.6, How.READ, 1.0), None, Match.SAME),
        (Known(1.2, How.READ, 1.0), None, Match.DIFFERENT),
        (Known(1.6, How.READ, 1.0), Ended(EndReason.RESTARTED, 1.5), Match.UNKNOWN),
        (None, None, Match.UNKNOWN),
    ],
)
def test_rows_of_the_comparison(known: Known | None, ended: Ended | None, match: Match) -> None:
    values = {} if known is None else {"freefall_time_s": known}
    view = ConversationView(number=1, ended=ended, values=MappingProxyType(values))
    for row in compare(Profile(name="p", settings={"freefall_time_s": 1.6}), view, 2.0):
        is_in_profile = row.command.key == "freefall_time_s"
        assert row.match is (match if is_in_profile else Match.NOT_IN_PROFILE)
        assert row.is_worth_applying is (is_in_profile and match is not Match.SAME)
