"""What mends a check that did not pass: the button of its row."""

from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, NamedTuple

from app.limits.limits import SETTING_BOUNDS
from app.preflight.findings import Case, CheckResult, Person
from app.preflight.module_checks import RecordsWord, records_word
from app.preflight.verdict import Judged
from app.settings.values import DEFAULTS
from protocol.fields import Value
from protocol.translatable import marked

if TYPE_CHECKING:
    from ui.pages.preflight.page import PreflightPage

LOCK_AND_ENABLE: Final = marked("Lock, enable and check again")


class Remedy(NamedTuple):
    """`words`: of the button, English, marked. `act` does it, here or on the page that has the control for it."""

    words: str
    act: Callable[["PreflightPage"], object]
    is_enabling: bool = False


_APPROVE: Final = marked("Approve these settings")
_MEASURE: Final = Remedy(marked("Measure"), lambda page: page.measure_light())
_SETTING_KEYS: Final = {bound.check: key for key, bound in SETTING_BOUNDS.items()}


def remedy(
    judged: Judged, case: Case, *, has_profile: bool, needs_lock: bool = False, looked_at: Counter[bytes] | None = None
) -> Remedy | None:
    """What mends a row with one click; None where only hands can.

    `looked_at`: the trigger records that a person had before them; only those can be called reviewed.
    """
    id_, is_known = judged.check.id, judged.finding.result is not CheckResult.UNKNOWN
    if judged.finding.result is CheckResult.PASS:
        return None
    match id_:
        case "attitude_trigger" | "freefall_trigger":
            words = LOCK_AND_ENABLE if needs_lock else marked("Enable now")
            return Remedy(words, lambda page: page.enable_and_check(), is_enabling=True)
        case "service":
            return Remedy(marked("Archive of all stations…"), lambda page: page.page_wanted.emit("archive"))
        case "trigger_records" if (word := records_word(case)) is not None and judged.blocks_go:
            if word is RecordsWord.REVIEWED and unseen_records(case, looked_at or Counter()):
                return Remedy(marked("Look at the records"), lambda page: page.look_at_records())
            return _said(word.value, Person(are_records_reviewed=True))
        case "trigger_records" | "triggered" if judged.blocks_go:
            return Remedy(marked("Triggers"), lambda page: page.page_wanted.emit("triggers"))
        case "boot_count" | "guided_tests" if case.past.module is None:
            return Remedy(marked("Name it"), lambda page: page.form.name_field.setFocus())
        case "boot_count" if judged.blocks_go and is_known:
            return _said(marked("It is this module"), Person(is_same_module=True))
        case "guided_tests":
            return Remedy(marked("Guided tests"), lambda page: page.show_view("guided"))
        case "fingerprint" if is_known and has_profile:
            return Remedy(_APPROVE, lambda page: page.approve())
        case "fingerprint" if is_known:
            return _said(_APPROVE, Person(are_settings_approved=True))
        case "light" if is_known:
            return _MEASURE
        case _ if is_known and id_ in _SETTING_KEYS:
            return _written(_SETTING_KEYS[id_], judged, case)
    return None


def unseen_records(case: Case, looked_at: Counter[bytes]) -> int:
    """How many records nobody has reviewed or looked at."""
    history = case.evidence.history
    if history is None:
        return 0
    return (Counter(record.raw for record in history.all) - case.past.reviewed - looked_at).total()


def _said(words: str, person: Person) -> Remedy:
    """Check again with what a person says by pressing it."""
    return Remedy(words, lambda page: page.check(person))


def _written(key: str, judged: Judged, case: Case) -> Remedy | None:
    """The profile's value, else the vendor's default; it is written in Settings, which asks what it always asks."""

    def with_value(words: str, value: Value) -> Remedy:
        return Remedy(words, lambda page: page.use_in_settings({key: value}))

    value = case.profile.settings.get(key)
    if judged.blocks_go and value is not None:
        return with_value(marked("Write the profile's value"), value)
    if key == "light_threshold_v":
        return _MEASURE
    return with_value(marked("Write the default"), DEFAULTS[key]) if judged.blocks_go else None
