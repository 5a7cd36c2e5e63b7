"""Checks of the settings, the triggers and the identity of the module."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from functools import partial
from typing import Final

from app.guided.results import TITLES, VERDICT_WORDS, GuidedKind, GuidedVerdict
from app.limits.limits import SETTING_BOUNDS
from app.limits.past import LastTested
from app.modules.names import NOT_NAMED, known_by
from app.preflight.findings import Case, Check, CheckResult, Finding, judged, unknown
from app.settings.values import value_text
from app.system.clock import DAY, local_time
from app.text.messages import UserMessage, joined, message
from protocol.catalogue import BY_NAME, READABLE_SETTINGS
from protocol.fields import Value
from protocol.translatable import marked

FINGERPRINT_KEYS = tuple(command.key for command in READABLE_SETTINGS)


def light_threshold(case: Case) -> Finding:
    """Without a profile the advice (the reading with the bay open) cannot be checked: a warning."""
    advice = message(marked("as read with the bay open"))
    finding = setting(case, "light_threshold", advice)
    is_compared = "light_threshold_v" in case.profile.settings
    if finding.result is not CheckResult.PASS or is_compared:
        return finding
    return Finding(CheckResult.WARN, finding.measured, finding.shown, advice)


def setting(case: Case, name: str, advice: UserMessage) -> Finding:
    """Equal to the profile's value if it has one, else within the advice; never beyond the bounds."""
    command = BY_NAME[name]
    target, bound = case.profile.settings.get(command.key), SETTING_BOUNDS[command.key]
    limit = advice if target is None else message(f"= {value_text(command, target)}")
    value = case.evidence.values.get(command.key)
    if value is None:
        return case.unread(command.key, limit)
    if not bound.low <= value <= bound.high:
        return judged(value, value_text(command, value), limit, is_fine=False)
    is_fine = bound.advised_low <= value <= bound.advised_high if target is None else value == target
    return judged(value, value_text(command, value), limit, is_fine=is_fine)


def trigger(case: Case, key: str) -> Finding:
    limit = message(marked("enabled in this conversation"))
    flag = case.evidence.flags.get(key)
    if flag is None:
        return case.unread(key, limit)
    if flag.is_enabled is not None:
        shown = message(marked("enabled") if flag.is_enabled else marked("DISABLED"))
        return judged(flag.is_enabled, shown, limit, is_fine=flag.is_enabled)
    do = None
    if case.evidence.is_active:  # nothing is written on an active module
        do = message(marked("Lock it, enable the triggers, activate it again."))
    return unknown(flag.why, limit, do=do)


def trigger_records(case: Case) -> Finding:
    reviewed = message(marked("all records reviewed"))
    limit = _under_name(case, reviewed)
    history = case.evidence.history
    if history is None:
        return case.unread("trigger_records", limit)
    if case.evidence.may_have_fired:
        why = message(marked("may have fired before the restart"))
        return unknown(why, limit, do=message(marked("Judge its records, then close the notice.")))
    if not history.is_answered:
        return _silent_records(case, limit)
    new = (Counter(record.raw for record in history.all) - case.past.reviewed).total()
    shown = message(marked("{new} of {total} not reviewed"), new=new, total=len(history.all))
    if new and not case.person.are_records_reviewed:
        return judged(new, shown, limit, is_fine=False) if case.past.has_check else unknown(shown, limit)
    if not history.is_confirmed:
        return unknown(message(marked("readings differ")), limit)
    return judged(0, _by_a_person(reviewed) if new else shown, limit, is_fine=True)


def _silent_records(case: Case, limit: UserMessage) -> Finding:
    """E7: a module that never fired may send nothing; only a person can tell, and only of one that never answered."""
    silent, past, evidence = message(marked("no reply")), case.past, case.evidence
    if any(status.triggered for status in evidence.statuses):
        shown = message(marked("{value}: {why}"), value=silent, why=message(marked("triggered")))
        return Finding(CheckResult.FAIL, None, shown, limit)
    if past.last_answer is not None:
        text = marked("no reply; had {count} on {date}")
        shown = message(text, count=past.last_answer.count, date=local_time(past.last_answer.at, DAY))
        do = message(marked("It answered before: read its label, restart it and check again."))
        return Finding(CheckResult.FAIL, None, shown, limit, do)
    is_all_else_answered = not evidence.faults and evidence.void is None
    if is_all_else_answered and (past.is_said_new or case.person.are_records_reviewed):
        do = message(marked("Somebody marked this module as new."))
        return Finding(CheckResult.WARN, None, message(marked("no reply: new, no records")), limit, do)
    return unknown(silent, limit, do=message(marked("If it is new, say so.")) if is_all_else_answered else None)


class RecordsWord(Enum):
    """What a person can say of the trigger records; the value is what a button says, in English, translatable."""

    REVIEWED = marked("Mark as reviewed")
    NEW_MODULE = marked("New, no records")


def records_word(case: Case) -> RecordsWord | None:
    """The word that would settle the check of the trigger records; None where a word settles nothing."""
    settled = (CheckResult.PASS, CheckResult.WARN)
    people = (replace(case.person, are_records_reviewed=is_said) for is_said in (False, True))
    before, after = (trigger_records(replace(case, person=person)) for person in people)
    history = case.evidence.history
    if history is None or before.result in settled or after.result not in settled:
        return None
    return RecordsWord.REVIEWED if history.is_answered else RecordsWord.NEW_MODULE


def _under_name(case: Case, limit: UserMessage) -> UserMessage:
    """A limit that comes from what is kept under the module's name."""
    known = known_by(case.past.module, is_by_option=case.person.is_named_by_option)
    return message(marked("{limit}; {known}"), limit=limit, known=known)


def _by_a_person(shown: UserMessage) -> UserMessage:
    return message(marked("{value}, confirmed by a person"), value=shown)


def boot_count(case: Case) -> Finding:
    past, count = case.past, case.evidence.values.get("boot_count")
    known = past.remembered
    before = None if known is None else known.boot_count
    earlier = message(marked("≥ last visit")) if before is None else message(f"≥ {before}")
    limit = _under_name(case, earlier)
    if count is None:
        return case.unread("boot_count", limit)
    if past.module is None:
        return Finding(CheckResult.WARN, count, UserMessage(str(count)), limit, message(marked("Name the module.")))
    if known is None or before is None:
        do = message(marked("On the first visit continue; otherwise compare the count by hand."))
        return Finding(CheckResult.WARN, count, _with_reason(count, message(marked("no earlier visit"))), limit, do)
    if case.person.is_same_module:
        return judged(count, _by_a_person(message(str(count))), limit, is_fine=True)
    if known.is_past(int(count)):
        why = message(marked("another module?"))
        return judged(count, _with_reason(count, why), limit, is_fine=False)
    if not past.do_records_follow:
        why = message(marked("other trigger records, another module?"))
        return judged(count, _with_reason(count, why), limit, is_fine=False)
    return judged(count, str(count), limit, is_fine=True)


def _with_reason(count: Value, why: UserMessage) -> UserMessage:
    return message(marked("{value}: {why}"), value=count, why=why)


def settings_fingerprint(case: Case) -> Finding:
    approved = case.profile.approved_fingerprint or case.past.fingerprint
    limit = message(marked("none approved")) if approved is None else UserMessage(approved)
    if case.profile.approved_fingerprint is None:
        limit = _under_name(case, limit)
    code = case.settings_code
    if code is None:
        missing = next(key for key in FINGERPRINT_KEYS if key not in case.evidence.values)
        return case.unread(missing, limit)
    if code != approved and case.person.are_settings_approved:
        return judged(code, _by_a_person(UserMessage(code)), UserMessage(code), is_fine=True)
    if approved is None:
        return Finding(CheckResult.WARN, code, UserMessage(code), limit)
    return judged(code, code, limit, is_fine=code == approved)


def guided_tests(case: Case) -> Finding:
    """The tests that the profile demands; without a demand a test that failed last is a warning."""
    demanded, past = case.profile.tests_within_days, case.past
    demands = [
        message(marked("{test} within {days} days"), test=UserMessage(TITLES[kind]), days=days)
        for kind, days in demanded.items()
    ]
    none = message(marked("none"))
    limit = _under_name(case, joined(demands) if demands else none)
    if demanded and past.module is None:
        return unknown(NOT_NAMED, limit)
    against = [kind for kind, days in demanded.items() if not _holds(past.tests.get(kind), days)]
    failed = [kind for kind, last in past.tests.items() if last.stored.verdict is GuidedVerdict.FAILED]
    listed = against or failed or [kind for kind in GuidedKind if kind in past.tests]
    shown = joined([_last_tested(kind, past.tests.get(kind)) for kind in listed]) if listed else none
    result = CheckResult.FAIL if against else CheckResult.WARN if failed else CheckResult.PASS
    return Finding(result, len(against), shown, limit)


def service(case: Case) -> Finding:
    """What a person has to do to the module: overdue is a warning, or not met where the profile says so. A module that
    may have fired and was not repacked is never fit."""
    due = case.past.due
    limit = _under_name(case, message(marked("nothing overdue")))
    is_against = any(service.is_after_firing for service in due)
    if case.past.module is None and case.profile.is_service_required and not is_against:
        return unknown(NOT_NAMED, limit)
    shown = joined([service.text for service in due], between=" ") if due else message(marked("none"))
    is_against |= case.profile.is_service_required and any(service.is_overdue for service in due)
    result = CheckResult.FAIL if is_against else CheckResult.WARN if due else CheckResult.PASS
    return Finding(result, len(due), shown, limit)


def _holds(last: LastTested | None, days: int) -> bool:
    is_passed = last is not None and last.stored.verdict is GuidedVerdict.PASSED
    return is_passed and last is not None and last.age_days is not None and last.age_days <= days


def _last_tested(kind: GuidedKind, last: LastTested | None) -> UserMessage:
    """ "Free fall: passed (3 d)"."""
    test = UserMessage(TITLES[kind])
    if last is None:
        return message(marked("{value}: {why}"), value=test, why=message(marked("not tested")))
    days = "?" if last.age_days is None else f"{last.age_days:.0f}"
    return message(
        "{test}: {verdict} ({days} d)", test=test, verdict=message(VERDICT_WORDS[last.stored.verdict]), days=days
    )


_SETTING = marked("Write it on the Settings page.")
_TRIGGER = marked("Enable now.")


def _setting(name: str, advice: str) -> Callable[[Case], Finding]:
    return partial(setting, name=name, advice=message(advice))


MODULE_CHECKS: Final = (
    Check("attitude_threshold", marked("Attitude threshold"), _setting("attitude_threshold", "55–90°"),
          marked("Too low, it fires in a turn; too high, it fires too late."), _SETTING),
    Check("freefall_acceleration", marked("Free-fall acceleration threshold"),
          _setting("freefall_acceleration", "0.1–0.6 g"),
          marked("Too high, it fires in a descent; too low, it misses falls."), _SETTING),
    Check("freefall_time", marked("Free-fall time"), _setting("freefall_time", "0.50–2.55 s"),
          marked("Too short, it fires without need; too long, it costs height."), _SETTING),
    Check("light_threshold", marked("Light threshold"), light_threshold,
          marked("Light in the parachute bay: tells whether it is open."),
          marked("Measure the light threshold.")),
    Check("attitude_trigger", marked("Attitude trigger enabled"), partial(trigger, key="attitude_trigger"),
          marked("The module cannot say whether it is enabled."), _TRIGGER),
    Check("freefall_trigger", marked("Free-fall trigger enabled"), partial(trigger, key="freefall_trigger"),
          marked("The module cannot say whether it is enabled."), _TRIGGER),
    Check("trigger_records", marked("No new trigger record"), trigger_records,
          marked("An unexplained trigger can happen again."),
          marked("Judge it on the Triggers page.")),
    Check("boot_count", marked("Boot count"), boot_count,
          marked("The module counts its starts; a lower count than before is another module's."),
          marked("Make sure which module this is.")),
    Check("fingerprint", marked("Settings as approved"), settings_fingerprint,
          marked("One code for all readable settings."),
          marked("Write what differs from the profile, or approve.")),
    Check("guided_tests", marked("Guided tests"), guided_tests,
          marked("Only a test by hand proves the sensors."),
          marked("Name the module, then do the guided tests.")),
    Check("service", marked("Service due"), service,
          marked("A parachute, its ejector and its cell age."),
          marked("Do it, and keep it in the archive: Service…")),
)  # fmt: skip
