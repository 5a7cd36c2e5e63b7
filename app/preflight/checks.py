"""The checks: what each is given, how it judges that, and its result with measurement and limit.

Those of the line, the module's state and its sensors come first, then its settings, its triggers, and which module it
is. A check never guesses: what was not read is unknown, and unknown stands against GO.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import partial
from typing import Final, NamedTuple

from app.guided.results import TITLES, VERDICT_WORDS, GuidedKind, GuidedVerdict
from app.limits.limits import SETTING_BOUNDS, OutOfLimit, cell_outside, is_bay_open, least_cell_text
from app.limits.past import LastTested, Past
from app.preflight.evidence import CHECK_LINK, FIND_OUT_WHY, HEARTBEATS, STILL_S, UNFINISHED, Evidence
from app.procedures.read import ANSWERED_TWICE, NO_REPLY
from app.settings.profiles import LIMITS, Profile
from app.settings.values import SETTINGS_BY_KEY, fingerprint, value_text
from app.system.clock import DAY, local_time
from app.text.messages import UserMessage, joined, message
from protocol.catalogue import READABLE_SETTINGS
from protocol.fields import Value
from protocol.translatable import marked

# About forty come in two seconds.
REPORTS_NEEDED = 15
# So many of three answers make cell voltage, charging and light known.
_ANSWERS_NEEDED = 2
YES = message(marked("yes"))
CHECK_LINE = message(marked("Make sure that one module only is on this line; else do not fly."))
NOT_NAMED = message(marked("module not named"))
_NONE = message(marked("none"))


class CheckResult(Enum):
    """The value is the word in the JSON output."""

    PASS = "pass"  # noqa: S105  no password
    FAIL = "fail"
    # Does not stand against GO.
    WARN = "warn"
    # Counts as failed: what nobody could read may be the one thing that is wrong.
    UNKNOWN = "unknown"


RESULT_WORDS = {
    CheckResult.PASS: marked("passed"),
    CheckResult.FAIL: marked("FAILED"),
    CheckResult.WARN: marked("warning"),
    CheckResult.UNKNOWN: marked("UNKNOWN"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Person:
    """The entries of a person for a check. `module` is None where it has no name."""

    who: str = ""
    module: str | None = None
    aircraft: str = ""
    # The trigger records on the module have been reviewed or, where it is silent to the query, it is new.
    are_records_reviewed: bool = False
    # Said by the person although boot count or records speak against it.
    is_same_module: bool = False
    # Approved by the person although they are not those of the last check that passed, or none did.
    are_settings_approved: bool = False


class RecordsWord(Enum):
    """A person's word for the trigger records; the value is what a button says, in English, translatable."""

    REVIEWED = marked("Mark as reviewed")
    NEW_MODULE = marked("New, no records")


class Finding(NamedTuple):
    """`measured`: for programs, in the unit of `shown`, None if unknown. `do`: what to do, None: the check's own.
    `word`: the one that settles it, or has settled it."""

    result: CheckResult
    measured: Value | str | None
    shown: UserMessage
    limit: UserMessage
    do: UserMessage | None = None
    word: RecordsWord | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """Input of the checks. `profile`: what is expected, with a person's answers for its manual checks."""

    evidence: Evidence
    profile: Profile
    past: Past
    person: Person = Person()

    @property
    def settings_code(self) -> str | None:
        """None where not all settings that it covers are known."""
        return fingerprint(self.evidence.values)

    def unread(self, key: str, limit: UserMessage) -> Finding:
        """What the check is about may well be in order."""
        void = self.evidence.void
        why = message(marked("not asked")) if void is None else void.message
        if key in self.evidence.unanswered:
            why = message(NO_REPLY)
        return _unknown(why, limit, CHECK_LINK if void is None else void.do)

    def answers(self, key: str) -> list[Value]:
        """All answers of three; none where too few came."""
        values = self.evidence.series.get(key, [])
        return values if len(values) >= _ANSWERS_NEEDED else []

    def under_name(self, limit: UserMessage) -> UserMessage:
        """A limit that comes from what is kept under the module's name; it says by what the module is known."""
        if not self.past.module:
            return message(marked("{limit}; module not named"), limit=limit)
        text = marked("{limit}; {module}, named by a person")
        return message(text, limit=limit, module=self.past.module)


class Check(NamedTuple):
    """`id` is the one in the JSON output; texts are English, translatable."""

    id: str
    title: str
    judge: Callable[[Case], Finding]
    why: str
    do: str


def _unknown(why: UserMessage, limit: UserMessage, do: UserMessage | None = None) -> Finding:
    return Finding(CheckResult.UNKNOWN, None, why, limit, do)


def _judged(measured: Value | str, shown: str | UserMessage, limit: UserMessage, *, is_fine: bool) -> Finding:
    text = shown if isinstance(shown, UserMessage) else UserMessage(shown)
    return Finding(CheckResult.PASS if is_fine else CheckResult.FAIL, measured, text, limit)


def _because(value: object, why: UserMessage) -> UserMessage:
    return message(marked("{value}: {why}"), value=value, why=why)


def _by_a_person(value: object) -> UserMessage:
    return message(marked("{value}, confirmed by a person"), value=value)


# The line


def _connection(case: Case) -> Finding:
    limit, void = message(marked("no interruption")), case.evidence.void
    if void is not None:
        return Finding(CheckResult.FAIL, False, void.message, limit, void.do)
    if case.evidence.ended_at is None:
        return _unknown(UNFINISHED.message, limit)
    return _judged(True, YES, limit, is_fine=True)


def _read_twice(case: Case) -> Finding:
    """Two readings that differ have ended the conversation."""
    limit = message(marked("same"))
    if case.evidence.is_answered_twice:
        return Finding(CheckResult.FAIL, False, ANSWERED_TWICE, limit, CHECK_LINE)
    if len(case.evidence.states) < 2:
        return case.unread("status", limit)
    if not all(state.is_complete for state in case.evidence.states):
        return _unknown(message(marked("not read again")), limit, CHECK_LINK)
    return _judged(True, YES, limit, is_fine=True)


def _link_loss(case: Case) -> Finding:
    evidence, most = case.evidence, case.profile.limit("heartbeats_lost_max")
    sent, lost, invalid = evidence.heartbeats_sent, evidence.heartbeats_lost, evidence.rejected_bytes
    text = marked("{lost} of {sent} lost, invalid bytes: {bytes}")
    limit = message(text, lost=f"≤ {most:g}" if most else 0, sent=HEARTBEATS, bytes=0)
    if sent == 0:
        return case.unread("heartbeat", limit)
    is_fine = sent >= HEARTBEATS and lost <= most and not invalid
    return _judged(lost, message(text, lost=lost, sent=sent, bytes=invalid), limit, is_fine=is_fine)


def _round_trip(case: Case) -> Finding:
    most_ms = case.profile.limit("round_trip_max_ms")
    limit = message(f"≤ {most_ms:g} ms")
    trips = sorted(case.evidence.round_trips_s)
    if not trips:
        return case.unread("heartbeat", limit)
    slowest_ms, median_ms = 1000 * trips[-1], 1000 * trips[len(trips) // 2]
    shown = message(marked("{slowest:.1f} ms, median {median:.1f} ms"), slowest=slowest_ms, median=median_ms)
    return _judged(round(slowest_ms, 1), shown, limit, is_fine=slowest_ms <= most_ms)


# The module's state and its sensors


def _not_triggered(case: Case) -> Finding:
    limit = message(marked("not triggered"))
    otherwise = case.evidence.contradiction_of("triggered")
    if not case.evidence.statuses:
        return case.unread("status", limit)
    if otherwise is not None:
        return _unknown(otherwise, limit, CHECK_LINE)
    has_fired = case.evidence.has_triggered
    return _judged(has_fired, message(marked("TRIGGERED")) if has_fired else limit, limit, is_fine=not has_fired)


def _activation(case: Case) -> Finding:
    """Passes locked and active; which of them decides between READY and GO."""
    limit, statuses = message(marked("the same throughout; GO: active")), case.evidence.statuses
    otherwise = case.evidence.contradiction_of("active")
    if not statuses:
        return case.unread("status", limit)
    if otherwise is not None:
        return _unknown(otherwise, limit, CHECK_LINE)
    if len({status.active for status in statuses}) > 1:
        return Finding(CheckResult.FAIL, None, message(marked("changed")), limit)
    is_active = bool(case.evidence.is_active)
    return _judged(is_active, message(marked("ACTIVE") if is_active else marked("locked")), limit, is_fine=True)


def _too_few(case: Case, limit: UserMessage) -> Finding | None:
    """Why nothing is known of the two seconds: the reports are too few, or do not cover them."""
    reports = case.evidence.reports
    if not reports:
        return case.unread("status", limit)
    if len(reports) < REPORTS_NEEDED or reports[-1].at - reports[0].at < STILL_S * 0.75:
        return _unknown(message(marked("reports in 2 s: only {count}"), count=len(reports)), limit, CHECK_LINK)
    return None


def _tilt(case: Case) -> Finding:
    most = case.profile.limit("tilt_max_deg")
    limit = message(f"≤ {most:g}°")
    highest = max((report.tilt_deg for report in case.evidence.reports), default=0.0)
    return _too_few(case, limit) or _judged(highest, f"{highest:.0f}°", limit, is_fine=highest <= most)


def _one_g(case: Case) -> Finding:
    least, most = case.profile.limit("acceleration_min_g"), case.profile.limit("acceleration_max_g")
    limit = message(f"{least:g}–{most:g} g")
    values = [report.acceleration_g for report in case.evidence.reports]
    worst = max(values, key=lambda value: abs(value - 1.0), default=0.0)
    is_fine = all(least <= value <= most for value in values)
    return _too_few(case, limit) or _judged(worst, f"{worst:.1f} g", limit, is_fine=is_fine)


def _steady(case: Case, key: str, limit_name: str, shown: str) -> Finding:
    """`shown`: how a width is written."""
    most = case.profile.limit(limit_name)
    limit = message(LIMITS[limit_name].shown.format(most).join(("≤ ", " / 2 s")))
    values = [getattr(report, key) for report in case.evidence.reports] or [0.0]
    width = round(max(values) - min(values), 1)
    return _too_few(case, limit) or _judged(width, shown.format(width), limit, is_fine=width <= most)


def _cell_voltage(case: Case) -> Finding:
    limit = message(f"≥ {least_cell_text(case.profile)}")
    volts = [float(value) for value in case.answers("cell_voltage_v")]
    if not volts:
        return case.unread("cell_voltage_v", limit)
    lowest, highest, shown = min(volts), max(volts), f"{min(volts):.2f} V"
    if cell_outside(lowest, case.profile, is_charging=None) is not None:
        return _judged(lowest, shown, limit, is_fine=False)
    # With external power the charging voltage is read, which is above the cell's: it only proves that a cell is low.
    charging = case.answers("charging")
    if not charging or any(charging):
        why = message(marked("{voltage} may be the charger's"), voltage=shown)
        return _unknown(why, limit, message(marked("Unplug the external power.")))
    if cell_outside(highest, case.profile, is_charging=False) is not None:
        why = _because(f"{highest:.2f} V", message(OutOfLimit.CELL_HIGH.value))
        return _judged(highest, why, limit, is_fine=False)
    return _judged(lowest, shown, limit, is_fine=True)


def _not_charging(case: Case) -> Finding:
    limit, states = message(marked("no external power")), case.answers("charging")
    if not states:
        return case.unread("charging", limit)
    is_charging = any(states)
    shown = message(marked("charging") if is_charging else marked("confirmed"))
    return _judged(is_charging, shown, limit, is_fine=not is_charging)


def _bay_closed(case: Case) -> Finding:
    threshold = case.evidence.values.get("light_threshold_v")
    if threshold is None:
        return case.unread("light_threshold_v", message(marked("Light threshold")))
    is_inverted = case.profile.is_light_inverted
    limit = message(f"{'>' if is_inverted else '<'} {threshold:.1f} V")
    tested = case.past.tests.get(GuidedKind.BAY)
    if not is_inverted and (tested is None or tested.stored.verdict is not GuidedVerdict.PASSED):
        limit = message(marked("{limit} (assumed)"), limit=limit)  # which side of the threshold is dark (E11)
    lights = [float(value) for value in case.answers("light_v")]
    if not lights:
        return case.unread("light_v", limit)
    worst = min(lights) if is_inverted else max(lights)
    is_open = is_bay_open(worst, float(threshold), is_inverted=is_inverted)
    return _judged(worst, f"{worst:.1f} V", limit, is_fine=not is_open)


# Its settings and triggers


def _setting(case: Case, key: str, advice: UserMessage | None = None) -> Finding:
    """Equal to the profile's value if it has one, else within the advice; never beyond the bounds. `advice`: one that
    cannot be checked, so that without a profile it is a warning."""
    command, bound, target = SETTINGS_BY_KEY[key], SETTING_BOUNDS[key], case.profile.settings.get(key)
    limit = advice or bound.advice if target is None else message(f"= {value_text(command, target)}")
    value = case.evidence.values.get(key)
    if value is None:
        return case.unread(key, limit)
    is_fine = bound.advised_low <= value <= bound.advised_high if target is None else value == target
    is_fine &= bound.low <= value <= bound.high
    found = _judged(value, value_text(command, value), limit, is_fine=is_fine)
    return found._replace(result=CheckResult.WARN) if is_fine and limit is advice else found


def _trigger(case: Case, key: str) -> Finding:
    limit, flag = message(marked("enabled in this conversation")), case.evidence.flags.get(key)
    if flag is None:
        return case.unread(key, limit)
    if flag.is_enabled is not None:
        shown = message(marked("enabled") if flag.is_enabled else marked("DISABLED"))
        return _judged(flag.is_enabled, shown, limit, is_fine=flag.is_enabled)
    # Nothing is written on an active module.
    lock_first = message(marked("Lock it, enable the triggers, activate it again."))
    return _unknown(flag.why, limit, lock_first if case.evidence.is_active else None)


# Which module it is, and what is kept of it


def _trigger_records(case: Case) -> Finding:
    reviewed, evidence, past = message(marked("all records reviewed")), case.evidence, case.past
    limit, history = case.under_name(reviewed), evidence.history
    if history is None:
        return case.unread("trigger_records", limit)
    # Before a brown-out while firing it may not have written its record.
    if evidence.may_have_fired:
        why = message(marked("may have fired before the restart"))
        return _unknown(why, limit, message(marked("Judge its records, then close the notice.")))
    if history.is_answered:
        new = (Counter(record.raw for record in history.all) - past.reviewed).total()
        shown = message(marked("{new} of {total} not reviewed"), new=new, total=len(history.all))
        # Before the first GO nobody knows what these records are; after it a new one is a trigger in between.
        if new and not case.person.are_records_reviewed:
            found = _judged(new, shown, limit, is_fine=False) if past.has_check else _unknown(shown, limit)
        elif not history.is_confirmed:
            found = _unknown(message(marked("readings differ")), limit)
        else:
            found = _judged(0, _by_a_person(reviewed) if new else shown, limit, is_fine=True)
        # It settles nothing where a record may be missing.
        return found._replace(word=RecordsWord.REVIEWED if new and history.is_confirmed else None)
    # E7: a module that never fired may send nothing; only a person can tell, and only of one that never answered.
    silent = message(NO_REPLY)
    if evidence.has_triggered:
        return Finding(CheckResult.FAIL, None, _because(silent, message(marked("triggered"))), limit)
    if past.last_answer is not None:
        text = marked("no reply; had {count} on {date}")
        count, at = len(past.last_answer.content.slots), past.last_answer.at
        shown = message(text, count=count, date=local_time(at, DAY))
        do = message(marked("It answered before: read its label, restart it and check again."))
        return Finding(CheckResult.FAIL, None, shown, limit, do)
    if evidence.unanswered or evidence.void is not None:
        return _unknown(silent, limit)
    word = None if past.is_said_new else RecordsWord.NEW_MODULE
    if past.is_said_new or case.person.are_records_reviewed:
        do = message(marked("Somebody marked this module as new."))
        return Finding(CheckResult.WARN, None, message(marked("no reply: new, no records")), limit, do, word)
    return Finding(CheckResult.UNKNOWN, None, silent, limit, message(marked("If it is new, say so.")), word)


def _boot_count(case: Case) -> Finding:
    past, count = case.past, case.evidence.values.get("boot_count")
    known = past.remembered
    before = None if known is None else known.boot_count
    limit = case.under_name(message(marked("≥ last visit")) if before is None else message(f"≥ {before}"))
    if count is None:
        return case.unread("boot_count", limit)
    shown = UserMessage(str(count))
    if past.module is None:
        return Finding(CheckResult.WARN, count, shown, limit, message(marked("Name the module.")))
    if known is None or before is None:
        do = message(marked("On the first visit continue; otherwise compare the count by hand."))
        return Finding(CheckResult.WARN, count, _because(count, message(marked("no earlier visit"))), limit, do)
    if case.person.is_same_module:
        return _judged(count, _by_a_person(shown), limit, is_fine=True)
    if known.is_past(int(count)):
        return _judged(count, _because(count, message(marked("another module?"))), limit, is_fine=False)
    if not past.do_records_follow:
        why = message(marked("other trigger records, another module?"))
        return _judged(count, _because(count, why), limit, is_fine=False)
    return _judged(count, shown, limit, is_fine=True)


def _fingerprint(case: Case) -> Finding:
    approved = case.profile.approved_fingerprint or case.past.fingerprint
    limit = message(marked("none approved")) if approved is None else UserMessage(approved)
    if case.profile.approved_fingerprint is None:
        limit = case.under_name(limit)
    code = case.settings_code
    # Never a code of what is partly known: it would be approved and then never come again.
    if code is None:
        known = case.evidence.settings
        return case.unread(next(one.key for one in READABLE_SETTINGS if one.key not in known), limit)
    if code != approved and case.person.are_settings_approved:
        return _judged(code, _by_a_person(code), UserMessage(code), is_fine=True)
    if approved is None:
        return Finding(CheckResult.WARN, code, UserMessage(code), limit)
    return _judged(code, code, limit, is_fine=code == approved)


def _guided_tests(case: Case) -> Finding:
    """The tests that the profile demands; without a demand a test that failed last is a warning."""
    demanded, past = case.profile.tests_within_days, case.past
    demands = [
        message(marked("{test} within {days} days"), test=UserMessage(TITLES[kind]), days=days)
        for kind, days in demanded.items()
    ]
    limit = case.under_name(joined(demands) if demands else _NONE)
    if demanded and past.module is None:
        return _unknown(NOT_NAMED, limit)

    def holds(last: LastTested | None, days: int) -> bool:
        is_passed = last is not None and last.stored.verdict is GuidedVerdict.PASSED
        return is_passed and last is not None and last.age_days is not None and last.age_days <= days

    def told(kind: GuidedKind) -> UserMessage:
        """ "Free fall: passed (3 d)"."""
        test, last = UserMessage(TITLES[kind]), past.tests.get(kind)
        if last is None:
            return _because(test, message(marked("not tested")))
        days = "?" if last.age_days is None else f"{last.age_days:.0f}"
        verdict = message(VERDICT_WORDS[last.stored.verdict])
        return message("{test}: {verdict} ({days} d)", test=test, verdict=verdict, days=days)

    against = [kind for kind, days in demanded.items() if not holds(past.tests.get(kind), days)]
    failed = [kind for kind, last in past.tests.items() if last.stored.verdict is GuidedVerdict.FAILED]
    listed = against or failed or [kind for kind in GuidedKind if kind in past.tests]
    result = CheckResult.FAIL if against else CheckResult.WARN if failed else CheckResult.PASS
    return Finding(result, len(against), joined([told(kind) for kind in listed]) if listed else _NONE, limit)


def _service(case: Case) -> Finding:
    """Judge the services that the module needs: an overdue one is a warning, or not met where the profile says so. A
    module that may have fired and was not repacked is never fit."""
    due, is_required = case.past.due, case.profile.is_service_required
    limit = case.under_name(message(marked("nothing overdue")))
    is_against = any(service.is_after_firing for service in due)
    if case.past.module is None and is_required and not is_against:
        return _unknown(NOT_NAMED, limit)
    is_against |= is_required and any(service.is_overdue for service in due)
    result = CheckResult.FAIL if is_against else CheckResult.WARN if due else CheckResult.PASS
    shown = joined([service.text for service in due], between=" ") if due else _NONE
    return Finding(result, len(due), shown, limit)


_WRITE_IT, _ENABLE = marked("Write it on the Settings page."), marked("Enable now.")
_CANNOT_SAY = marked("The module cannot say whether it is enabled.")
# All pre-flight checks, in the order of the page, of the record and of the JSON output.
CHECKS: Final[tuple[Check, ...]] = (
    Check("connection", marked("No interruption"), _connection,
          marked("Earlier values no longer count."),
          marked("Check cable and power.")),
    Check("read_twice", marked("Same when read twice"), _read_twice,
          marked("What is read twice and agrees is one module's."),
          marked("Check cable and power.")),
    Check("link_loss", marked("Link: loss"), _link_loss,
          marked("A bad line loses or falsifies values."),
          marked("Check plugs, ground and cable length.")),
    Check("round_trip", marked("Link: response time"), _round_trip,
          marked("Slow replies point to a bad adapter or a busy computer."),
          marked("Use another adapter or USB socket.")),
    Check("triggered", marked("Not triggered"), _not_triggered,
          marked("The parachute is spent."), FIND_OUT_WHY),
    Check("activation", marked("Activation"), _activation,
          marked("An active module fires when it tips over or falls."),
          marked("Send no commands during the check.")),
    Check("tilt", marked("Tilt: level"), _tilt,
          marked("A wrong zero fires too early or too late."),
          marked("Set the aircraft level, or zero the sensor.")),
    Check("tilt_spread", marked("Tilt: steady"),
          partial(_steady, key="tilt_deg", limit_name="tilt_spread_max_deg", shown="{:.0f}°"),
          marked("A drifting sensor is loose or failing."),
          marked("Do not touch the aircraft; check the mounting.")),
    Check("acceleration", marked("Acceleration: 1 g"), _one_g,
          marked("If it is not 1 g at rest, free fall is misjudged."),
          marked("Set the aircraft down; if the value stays, do not fly.")),
    Check("acceleration_spread", marked("Acceleration: steady"),
          partial(_steady, key="acceleration_g", limit_name="acceleration_spread_max_g", shown="{:.1f} g"),
          marked("Noise can end or fake a free fall."),
          marked("Stop motors and fans.")),
    Check("cell_voltage", marked("Cell voltage"), _cell_voltage,
          marked("A weak cell may not deploy the parachute."),
          marked("Charge it, unplug it, wait a minute.")),
    Check("charging", marked("Charger disconnected"), _not_charging,
          marked("The charger hides the cell's voltage."),
          marked("Unplug the external power.")),
    Check("light", marked("Bay closed"), _bay_closed,
          marked("More light reading higher is assumed until it was measured with the bay closed and open."),
          marked("Close the bay, or measure the light threshold.")),
    Check("attitude_threshold", marked("Attitude threshold"), partial(_setting, key="attitude_threshold_deg"),
          marked("Too low, it fires in a turn; too high, it fires too late."), _WRITE_IT),
    Check("freefall_acceleration", marked("Free-fall acceleration threshold"),
          partial(_setting, key="freefall_acceleration_g"),
          marked("Too high, it fires in a descent; too low, it misses falls."), _WRITE_IT),
    Check("freefall_time", marked("Free-fall time"), partial(_setting, key="freefall_time_s"),
          marked("Too short, it fires without need; too long, it costs height."), _WRITE_IT),
    Check("light_threshold", marked("Light threshold"),
          partial(_setting, key="light_threshold_v", advice=message(marked("as read with the bay open"))),
          marked("Light in the parachute bay: tells whether it is open."),
          marked("Measure the light threshold.")),
    Check("attitude_trigger", marked("Attitude trigger enabled"), partial(_trigger, key="attitude_trigger"),
          _CANNOT_SAY, _ENABLE),
    Check("freefall_trigger", marked("Free-fall trigger enabled"), partial(_trigger, key="freefall_trigger"),
          _CANNOT_SAY, _ENABLE),
    Check("trigger_records", marked("No new trigger record"), _trigger_records,
          marked("An unexplained trigger can happen again."),
          marked("Judge it on the Triggers page.")),
    Check("boot_count", marked("Boot count"), _boot_count,
          marked("The module counts its starts; a lower count than before is another module's."),
          marked("Make sure which module this is.")),
    Check("fingerprint", marked("Settings as approved"), _fingerprint,
          marked("One code for all readable settings."),
          marked("Write what differs from the profile, or approve.")),
    Check("guided_tests", marked("Guided tests"), _guided_tests,
          marked("Only a test by hand proves the sensors."),
          marked("Name the module, then do the guided tests.")),
    Check("service", marked("Service due"), _service,
          marked("A parachute, its ejector and its cell age."),
          marked("Do it, and keep it in the archive: Service…")),
)  # fmt: skip
