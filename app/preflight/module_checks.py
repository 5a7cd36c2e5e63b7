"""Checks of the settings, the triggers and the identity of the module: how each judges, then its entry."""

from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Final

from app.engine.identity import went_back
from app.guided.results import TITLES, GuidedKind, GuidedVerdict
from app.limits.expectations import LastTested
from app.limits.limits import SETTING_BOUNDS
from app.preflight.evidence import FlagFate
from app.preflight.findings import Case, Check, CheckResult, Finding, judged, unknown
from app.settings.fingerprint import COVERED
from app.settings.setting_texts import value_text
from app.text.messages import UserMessage, listed, said
from protocol.catalogue import BY_NAME
from protocol.translatable import marked

FINGERPRINT_KEYS = tuple(command.key for command in COVERED)


def light_threshold(case: Case) -> Finding:
    """Without a profile the advice (the reading with the bay open) cannot be proven: a person has to know."""
    advice = said(marked("as read with the bay open"))
    finding = setting(case, "light_threshold", advice)
    is_compared = "light_threshold_v" in case.expectations.settings
    if finding.result is not CheckResult.PASS or is_compared:
        return finding
    return Finding(CheckResult.WARN, finding.measured, finding.shown, advice)


def setting(case: Case, name: str, advice: UserMessage) -> Finding:
    """Equal to the profile's where that has one, else within the advice; never beyond the bounds."""
    command = BY_NAME[name]
    wanted, bound = case.expectations.settings.get(command.key), SETTING_BOUNDS[command.key]
    limit = advice if wanted is None else said(marked("exactly {limit}"), limit=value_text(command, wanted))
    value = case.evidence.values.get(command.key)
    if value is None:
        return unknown(case.fault(command.key), limit)
    if not bound.low <= value <= bound.high:
        shown = said(marked("{value}: {why}"), value=value_text(command, value), why=UserMessage(bound.why))
        return judged(value, shown, limit, is_fine=False)
    is_fine = bound.advised_low <= value <= bound.advised_high if wanted is None else value == wanted
    return judged(value, value_text(command, value), limit, is_fine=is_fine)


def trigger(case: Case, key: str) -> Finding:
    limit = said(marked("enabled, acknowledged since the last start"))
    flag = case.evidence.flags.get(key)
    if flag is None:
        return unknown(case.fault(key), limit)
    match flag.fate:
        case FlagFate.ENABLED if flag.logged is not None:
            text = marked("enabled: acknowledged {age} ago, same start of the module (audit log, entry {entry})")
            shown = said(text, age=_age(flag.logged.age_s), entry=str(flag.logged.entry))
            return Finding(CheckResult.PASS, True, shown, limit)
        case FlagFate.ENABLED:
            return Finding(CheckResult.PASS, True, said(marked("enabled: acknowledged")), limit)
        case FlagFate.DISABLED:
            return Finding(CheckResult.FAIL, False, said(marked("DISABLED: acknowledged")), limit)
        case FlagFate.REFUSED:
            return Finding(CheckResult.FAIL, None, said(marked("the module refused to enable it")), limit)
        case FlagFate.UNANSWERED:
            return unknown(said(marked("the module did not answer when it was enabled")), limit)
        case FlagFate.NOT_SENT:
            why = flag.why[0] if flag.why else said(marked("not sent"))
            return unknown(said(marked("not enabled: {why}"), why=why), limit, do=_lock_first(case))
        case FlagFate.NEVER_SET:
            why = said(marked("cannot be read, and no acknowledged set since the last start is known"))
            return unknown(why, limit, do=_lock_first(case))


def _age(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"


def _lock_first(case: Case) -> UserMessage | None:
    """Nothing is written on an active module."""
    if not case.evidence.is_active:
        return None
    return said(marked("Lock the module, enable the triggers with a check, and activate it again."))


def trigger_records(case: Case) -> Finding:
    limit = said(marked("all records reviewed"))
    history = case.evidence.history
    if history is None:
        return unknown(case.fault("trigger_records"), limit)
    if not history.is_answered:
        # E7: a module that never fired may send nothing. Only a person can know that.
        if case.are_records_looked_at:
            return Finding(CheckResult.WARN, None, said(marked("no answer; a person says that it never fired")), limit)
        return unknown(said(marked("no answer to the query for trigger records")), limit)
    new = (Counter(record.raw for record in history.all) - case.past.looked_at).total()
    total = str(len(history.all))
    if new and not case.are_records_looked_at:
        if case.past.has_check:
            shown = said(marked("{new} new since the last good check, {total} in all"), new=str(new), total=total)
            return judged(new, shown, limit, is_fine=False)
        why = said(marked("{new} of {total}, and no earlier good check knows them"), new=str(new), total=total)
        return unknown(why, limit)
    if not history.is_confirmed:
        return unknown(said(marked("no two readings agreed")), limit)
    if new:
        return judged(0, said(marked("{total}, reviewed by a person now"), total=total), limit, is_fine=True)
    return judged(0, said(marked("{total}, none new"), total=total), limit, is_fine=True)


def boot_count(case: Case) -> Finding:
    past, count = case.past, case.evidence.values.get("boot_count")
    if past.module is None:
        limit = said(marked("follows that of the named module"))
        if count is None:
            return unknown(case.fault("boot_count"), limit)
        shown = said(marked("{count}; the module has no name"), count=str(count))
        return Finding(
            CheckResult.WARN, count, shown, limit, said(marked("Name the module, so that it is known again."))
        )
    if past.boot_count is None:
        limit = said(marked("follows that of {module} before"), module=past.module)
        if count is None:
            return unknown(case.fault("boot_count"), limit)
        shown = said(marked("{count}; no memory of this module"), count=str(count))
        do = said(marked("At its first visit: continue. Else this computer's records were lost: compare by hand."))
        return Finding(CheckResult.WARN, count, shown, limit, do)
    limit = said(marked("not before {count}, where {module} was last"), count=str(past.boot_count), module=past.module)
    if count is None:
        return unknown(case.fault("boot_count"), limit)
    if case.is_same_module:
        return judged(count, said(marked("{count}; a person says that it is"), count=str(count)), limit, is_fine=True)
    if went_back(past.boot_count, int(count)):
        return judged(count, said(marked("{count}: is it the same module?"), count=str(count)), limit, is_fine=False)
    if not past.is_same_module:
        shown = said(marked("{count}, but its trigger records are others: is it the same module?"), count=str(count))
        return judged(count, shown, limit, is_fine=False)
    return judged(count, str(count), limit, is_fine=True)


def settings_fingerprint(case: Case) -> Finding:
    approved = case.expectations.approved_fingerprint or case.past.fingerprint
    limit = said(marked("none approved yet")) if approved is None else said(marked("{code}, approved"), code=approved)
    settings = case.evidence.settings(FINGERPRINT_KEYS)
    if case.fingerprint is None or len(settings) < len(FINGERPRINT_KEYS):
        missing = next((key for key in FINGERPRINT_KEYS if key not in settings), "")
        return unknown(case.fault(missing), limit)
    code = case.fingerprint(settings)
    if approved is None:
        return Finding(CheckResult.WARN, code, UserMessage(code), limit)
    return judged(code, code, limit, is_fine=code == approved)


def guided_tests(case: Case) -> Finding:
    """What the profile demands; without a demand, a test that failed last is worth a look."""
    wanted, past = case.expectations.tests_within_days, case.past
    demands = [_demand(kind, days) for kind, days in wanted.items()]
    limit = listed(demands) if demands else said(marked("none demanded"))
    if wanted and past.module is None:
        return unknown(said(marked("the module has no name")), limit)
    against = [kind for kind, days in wanted.items() if not _holds(past.tests.get(kind), days)]
    if against:
        shown = listed([_last_tested(kind, past.tests.get(kind)) for kind in against])
        return Finding(CheckResult.FAIL, len(against), shown, limit)
    failed = [kind for kind, last in past.tests.items() if last.kept.verdict is GuidedVerdict.FAILED]
    if failed:
        shown = listed([_last_tested(kind, past.tests[kind]) for kind in failed])
        return Finding(CheckResult.WARN, 0, shown, limit)
    done = [kind for kind in GuidedKind if kind in past.tests]
    shown = listed([_last_tested(kind, past.tests[kind]) for kind in done]) if done else said(marked("none done yet"))
    return Finding(CheckResult.PASS, 0, shown, limit)


def _holds(last: LastTested | None, days: int) -> bool:
    is_passed = last is not None and last.kept.verdict is GuidedVerdict.PASSED
    return is_passed and last is not None and last.age_days is not None and last.age_days <= days


def _demand(kind: GuidedKind, days: int) -> UserMessage:
    return said(marked("{test} within {days} days"), test=UserMessage(TITLES[kind]), days=str(days))


def _last_tested(kind: GuidedKind, last: LastTested | None) -> UserMessage:
    test = UserMessage(TITLES[kind])
    if last is None:
        return said(marked("{test} never"), test=test)
    when = _days_ago(last.age_days)
    match last.kept.verdict:
        case GuidedVerdict.PASSED:
            return said(marked("{test} {when}"), test=test, when=when)
        case GuidedVerdict.FAILED:
            return said(marked("{test} FAILED {when}"), test=test, when=when)
        case GuidedVerdict.UNCLEAR:
            return said(marked("{test} unclear {when}"), test=test, when=when)


def _days_ago(days: float | None) -> UserMessage:
    if days is None:
        return said(marked("at an unknown time"))
    return said(marked("today")) if days < 1 else said(marked("{days:.0f} days ago"), days=int(days))


_SETTING = marked("Write it on Settings until it is verified.")
_TRIGGER = marked("Choose “enable now” (--enable-triggers): only an acknowledged set says how it stands.")


def _setting(name: str, low: str, high: str) -> Callable[[Case], Finding]:
    return partial(setting, name=name, advice=said(marked("{low} to {high}"), low=low, high=high))


MODULE_CHECKS: Final = (
    Check("attitude_threshold", marked("Attitude threshold"), _setting("attitude_threshold", "55°", "90°"),
          marked("The angle at which it fires: too small fires in a turn, too large too late."), _SETTING),
    Check("freefall_acceleration", marked("Free-fall acceleration threshold"),
          _setting("freefall_acceleration", "0.1 g", "0.6 g"),
          marked("Too high fires in a descent, too low detects no fall."), _SETTING),
    Check("freefall_time", marked("Free-fall time"), _setting("freefall_time", "0.50 s", "2.55 s"),
          marked("Too short fires falsely, too long costs height."), _SETTING),
    Check("light_threshold", marked("Light threshold"), light_threshold,
          marked("It decides whether the parachute counts as having left the bay."),
          marked("Calibrate it with the bay closed and open, and keep it in a profile.")),
    Check("attitude_trigger", marked("Attitude trigger enabled"), partial(trigger, key="attitude_trigger"),
          marked("It fires when the aircraft tips over. The module cannot be asked whether it is enabled."), _TRIGGER),
    Check("freefall_trigger", marked("Free-fall trigger enabled"), partial(trigger, key="freefall_trigger"),
          marked("It fires in free fall. The module cannot be asked whether it is enabled."), _TRIGGER),
    Check("trigger_records", marked("No new trigger record"), trigger_records,
          marked("An unexplained trigger can happen again in flight."),
          marked("Judge it on Triggers: bench test, real or false.")),
    Check("boot_count", marked("Boot count fits the module"), boot_count,
          marked("The module has no serial number; its boot count only grows."),
          marked("Make sure which module this is, and name it.")),
    Check("fingerprint", marked("Settings as approved"), settings_fingerprint,
          marked("One code stands for all settings that can be read."),
          marked("Compare the settings with the profile and write what differs; or approve them.")),
    Check("guided_tests", marked("Guided tests"), guided_tests,
          marked("Only a test by hand shows that tilt, fall, bay and charger are noticed."),
          marked("Do them on the Tests page, with the module named.")),
)  # fmt: skip
