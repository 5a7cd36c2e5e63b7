"""What mends a check that did not pass: the button of its row."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Final

from app.limits.limits import SETTING_BOUNDS
from app.preflight.findings import Case, CheckResult, Person
from app.preflight.module_checks import RecordsWord, records_word
from app.preflight.verdict import Judged
from app.settings.values import DEFAULTS
from protocol.fields import Value
from protocol.translatable import marked

LOCK_AND_ENABLE: Final = marked("Lock, enable and check again")


class Mend(Enum):
    """How a row is mended: by checking again with what a person says, or on the page that is named."""

    CHECK = "preflight"
    ENABLE = "enable"
    NAME = "module"
    APPROVE = "profile"
    WRITE = "settings"
    MEASURE = "light"
    TRIGGERS = "triggers"
    REVIEW = "records"
    TESTS = "tests"
    SERVICE = "archive"


@dataclass(frozen=True, slots=True)
class Remedy:
    """`words`: of the button, English, marked. `values`: what `WRITE` puts into Settings, by key."""

    words: str
    mend: Mend
    stated: Person = field(default_factory=Person)
    values: Mapping[str, Value] = field(default_factory=dict)


_APPROVE: Final = marked("Approve these settings")
_MEASURE: Final = Remedy(marked("Measure"), Mend.MEASURE)
_SETTING_KEYS: Final = {bound.check: key for key, bound in SETTING_BOUNDS.items()}


def remedy(
    judged: Judged, case: Case, *, has_profile: bool, needs_lock: bool = False, looked_at: Counter[bytes] | None = None
) -> Remedy | None:
    """What mends a row with one click, here or on the page that has the control; None where only hands can.

    `looked_at`: the trigger records that a person had before them; only those can be called reviewed.
    """
    id_, is_known = judged.check.id, judged.finding.result is not CheckResult.UNKNOWN
    if judged.finding.result is CheckResult.PASS:
        return None
    match id_:
        case "attitude_trigger" | "freefall_trigger":
            return Remedy(LOCK_AND_ENABLE if needs_lock else marked("Enable now"), Mend.ENABLE)
        case "service":
            return Remedy(marked("Archive of all stations…"), Mend.SERVICE)
        case "trigger_records" if (word := records_word(case)) is not None and judged.blocks_go:
            if word is RecordsWord.REVIEWED and unseen_records(case, looked_at or Counter()):
                return Remedy(marked("Look at the records"), Mend.REVIEW)
            return Remedy(word.value, Mend.CHECK, Person(are_records_reviewed=True))
        case "trigger_records" | "triggered" if judged.blocks_go:
            return Remedy(marked("Triggers"), Mend.TRIGGERS)
        case "boot_count" | "guided_tests" if case.past.module is None:
            return Remedy(marked("Name it"), Mend.NAME)
        case "boot_count" if judged.blocks_go and is_known:
            return Remedy(marked("It is this module"), Mend.CHECK, Person(is_same_module=True))
        case "guided_tests":
            return Remedy(marked("Guided tests"), Mend.TESTS)
        case "fingerprint" if is_known and has_profile:
            return Remedy(_APPROVE, Mend.APPROVE)
        case "fingerprint" if is_known:
            return Remedy(_APPROVE, Mend.CHECK, Person(are_settings_approved=True))
        case "light" if is_known:
            return _MEASURE
        case _ if is_known and id_ in _SETTING_KEYS:
            return _write(_SETTING_KEYS[id_], judged, case)
    return None


def unseen_records(case: Case, looked_at: Counter[bytes]) -> int:
    """How many records nobody has reviewed or looked at."""
    history = case.evidence.history
    if history is None:
        return 0
    return (Counter(record.raw for record in history.all) - case.past.reviewed - looked_at).total()


def _write(key: str, judged: Judged, case: Case) -> Remedy | None:
    """The profile's value, else the vendor's default; it is written in Settings, which asks what it always asks."""
    value = case.profile.settings.get(key)
    if judged.blocks_go and value is not None:
        return Remedy(marked("Write the profile's value"), Mend.WRITE, values={key: value})
    if key == "light_threshold_v":
        return _MEASURE
    return Remedy(marked("Write the default"), Mend.WRITE, values={key: DEFAULTS[key]}) if judged.blocks_go else None
