"""Turns evidence into a filed record: judged against the module's history, signed, kept; and the checks that are kept,
listed without opening one.

Used by the window and the command line. Where the store fails, the verdict and the record are still made.
"""

import logging
from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta
from itertools import islice, pairwise
from pathlib import Path
from typing import Any, NamedTuple

from msgspec.structs import asdict

from app.engine.target import is_simulated
from app.guided.results import last_tests
from app.limits.past import LastTested, Past
from app.modules.names import remember, remembered
from app.modules.service import repack_due, service_due
from app.preflight.checks import Case, CheckResult, Person, RecordsWord
from app.preflight.evidence import Evidence
from app.preflight.verdict import Assessment, Verdict, assess
from app.records.record import Record, SignedRecord, make_record, read_document, record_of, sign
from app.settings.profiles import Profile
from app.store.acts import all_fired, unnamed_fired
from app.store.fact_store import Facts, Kept, Store, StoreError
from app.store.rows import PreflightCheck
from app.store.station import own_station
from app.system.clock import age_days
from app.system.files import data_folder
from app.text.messages import UserError, UserMessage, clean, message
from app.trigger_records.history import KeptTriggers, TriggersReading, file_triggers
from protocol.translatable import marked

_log = logging.getLogger(__name__)

# Number of checks of a module that are listed, and of those that are looked through in the window's thread.
LISTED = 200
LOOKED_AT = 20
# A rise by this between two checks is a charge; by less than the other it is none.
CHARGED_V = 0.1
STEADY_V = 0.04
WEEK = timedelta(days=7)


class Filed(NamedTuple):
    """`signed` is None where the key of this station cannot be used. `trouble`: why the record was not kept."""

    assessment: Assessment
    record: Record
    signed: SignedRecord | None
    trouble: UserError | None = None

    @property
    def exported(self) -> SignedRecord:
        """The record as it may leave this computer. Raises `UserError` where it could not be signed."""
        if self.signed is None:
            raise self.trouble or UserError(marked("The record is not signed."))
        return self.signed


def local_now() -> datetime:
    return datetime.now(UTC).astimezone()


def file_check(
    evidence: Evidence,
    profile: Profile,
    person: Person,
    *,
    store: Store | None,
    adapter: str = "",
    past: Past | None = None,
) -> Filed:
    """Judges, signs and keeps a check, also one that failed or was interrupted. `past`: the module's history before the
    check; None reads it from the store. `adapter`: USB identity of the adapter; where it is "" the port is used
    instead. Waits for the store."""
    at = local_now()
    adapter = adapter or evidence.port
    trouble: UserError | None = None
    if past is None:
        past = Past(module=person.module)
        if store is not None:
            try:
                past = store.read(lambda facts: _past(facts, person.module, evidence, adapter, at))
            except StoreError as error:
                trouble = error
    folder = data_folder() if store is None else store.folder
    filed = judge_check(evidence, profile, person, past, folder=folder, adapter=adapter, at=at)
    if store is None or trouble is not None or filed.signed is None:
        return filed._replace(trouble=trouble or filed.trouble)
    try:
        store.write_in_time(lambda facts: keep_check(facts, filed))
    except StoreError as error:
        return filed._replace(trouble=error)
    return filed


def judge_check(
    evidence: Evidence, profile: Profile, person: Person, past: Past, *, folder: Path, adapter: str, at: datetime
) -> Filed:
    """Judges and signs a check; it is not kept yet. `folder`: of this station's key."""
    assessment = assess(Case(evidence=evidence, profile=profile, past=past, person=person))
    record = make_record(assessment, at=at, adapter=adapter)
    try:
        return Filed(assessment, record, sign(record, own_station(folder)))
    except UserError as error:
        _log.warning("The record is not signed: %s", error)
        return Filed(assessment, record, None, error)


def _past(facts: Facts, name: str | None, evidence: Evidence, adapter: str, at: datetime) -> Past:
    """Checks and guided tests of a simulated module never count for a real one."""
    fired = unnamed_fired(facts, port=evidence.port, adapter=adapter)
    if name is None:  # one without a name that fired at this port may be this one
        due = repack_due(max((one.at for one in fired), default=None))
        return Past(due=() if due is None else (due,))
    history = evidence.history
    slots = None if history is None else [record.raw for record in history.records]
    is_confirmed = history is not None and history.is_confirmed
    counts_simulated = is_simulated(evidence.port)
    tests = last_tests(facts, name, counts_simulated=counts_simulated)
    triggers = KeptTriggers(facts)
    # From the newest on, as each is decoded with its document.
    kept = map(check_line, islice(facts.back_from_newest(PreflightCheck, name), LISTED))
    counted = (check for check in kept if counts_simulated or not check.is_simulated)
    passed = next((check for check in counted if check.has_passed), None)
    return Past(
        module=name,
        remembered=remembered(facts, name),
        reviewed=Counter(record.raw for record in triggers.records(name) if record.judgement is not None),
        has_check=passed is not None,
        do_records_follow=slots is None or triggers.do_follow(name, slots, is_confirmed=is_confirmed),
        last_answer=triggers.last_answer(name),
        is_said_new=triggers.is_said_new(name),
        fingerprint=None if passed is None else passed.code,
        tests={kind: LastTested(test, age_days(test.at, at)) for kind, test in tests.items()},
        due=service_due(facts, name, at, simulated=counts_simulated, more=fired),
    )


def keep_check(facts: Facts, filed: Filed) -> None:
    """The signed document, and beside it what lists show; under a name also what was read of the module. Within
    `Store.write`."""
    signed, assessment = filed.exported, filed.assessment
    record, evidence, person = signed.record, assessment.case.evidence, assessment.case.person
    name, history = person.module, evidence.history
    # The records may be another module's: they must not become part of this one's history.
    is_one_module = assessment.result("connection") is CheckResult.PASS
    is_one_module &= assessment.result("boot_count") is not CheckResult.FAIL
    if name is not None:
        remember(facts, name)
    check = PreflightCheck(
        verdict=record.verdict.value,  # type: ignore[arg-type]
        is_void=record.void is not None,
        is_simulated=record.is_simulated,
        who=record.who,
        aircraft=record.aircraft,
        code=record.settings_code,
        cell_voltage_v=record.cell_voltage_v,
        document=signed.text,
    )
    facts.add(check, record.module, at=record.at)
    if name is None or history is None or not is_one_module:
        return
    boots = evidence.values.get("boot_count")
    reading = TriggersReading(history, None if boots is None else int(boots), evidence.settings)
    # Whether the records follow is part of the check of the boot count.
    filed_as = file_triggers(facts, reading, name, port=evidence.port, adapter=record.adapter, is_same_module=True)
    if isinstance(filed_as, UserMessage):
        return
    # A person's word: the records are reviewed, or the module is new, until it reports a trigger.
    found = next(one.finding for one in assessment.checks if one.check.id == "trigger_records")
    word = found.word if person.are_records_reviewed else None
    triggers = KeptTriggers(facts)
    if evidence.has_triggered:
        triggers.say_new(name, is_new=False)
    elif word is RecordsWord.NEW_MODULE:
        triggers.say_new(name)
    if word is RecordsWord.REVIEWED:
        triggers.mark_reviewed(name, [kept.raw for kept in history.records])


# The checks that are kept


class CheckLine(PreflightCheck, frozen=True, kw_only=True):
    """One check as a list shows it, without its document. `id` names its fact, for `kept_record`; `at` is ISO 8601 in
    UTC; `is_fired_since` says that a deploy left or a TRIGGERED was seen after it, so that what it said of the module
    is no longer so."""

    id: str
    at: str
    module: str | None
    is_fired_since: bool

    @property
    def words(self) -> UserMessage:
        """The verdict, and what limits it."""
        word = message(self.verdict)
        if self.is_simulated:
            return message(marked("{verdict} (simulated)"), verdict=word)
        if self.is_fired_since:
            return message(marked("{verdict} (void: fired since)"), verdict=word)
        return message(marked("{verdict} (void)"), verdict=word) if self.is_void else word

    @property
    def has_passed(self) -> bool:
        """When it was made; its settings stay approved."""
        return not self.is_void and self.verdict in (Verdict.GO.value, Verdict.READY.value)

    @property
    def holds(self) -> bool:
        return self.has_passed and not self.is_fired_since


def check_line(check: Kept[PreflightCheck], fired: Iterable[Kept[Any]] = ()) -> CheckLine:
    """`fired`: when its module may have fired."""
    content = check.content
    is_fired_since = any(one.at > check.at and is_simulated(one.content.port) is content.is_simulated for one in fired)
    # Others may have written anything.
    shown = {"who": clean(content.who), "aircraft": clean(content.aircraft), "document": ""}
    return CheckLine(
        **(asdict(content) | shown),
        id=check.row.id,
        at=check.at,
        module=check.row.module,
        is_fired_since=is_fired_since,
    )


def checks_in(facts: Facts, module: str | None) -> tuple[CheckLine, ...]:
    """Newest first, of one module (None: modules without a name). Takes up to a millisecond for each: not for the
    window's thread."""
    fired = () if module is None else all_fired(facts, module)
    checks = islice(facts.back_from_newest(PreflightCheck, module), LISTED)
    return tuple(check_line(check, fired) for check in checks)


def kept_record(facts: Facts, id_: str) -> SignedRecord:
    """Return one check that is listed, as it was signed. Raises `UserError` for what this version cannot read."""
    check = facts.by_id(PreflightCheck, id_)
    text = "" if check is None else check.content.document
    document = read_document(text.encode())
    return SignedRecord(record_of(document), document.station, text)


def aircraft_of(facts: Facts, module: str) -> str:
    """Return the aircraft of this module's last check that names one, else ""."""
    checks = islice(facts.back_from_newest(PreflightCheck, module), LOOKED_AT)
    return next((check.content.aircraft for check in checks if check.content.aircraft), "")


def voltages_of(checks: Sequence[CheckLine]) -> list[tuple[datetime, float]]:
    """The cell's voltage at each check that measured it, from the oldest on; of a simulated module only where there is
    no other."""
    sound = [check for check in reversed(checks) if not check.is_void]
    measuring = [check for check in sound if not check.is_simulated] or sound
    found = [(datetime.fromisoformat(check.at), check.cell_voltage_v) for check in measuring]
    return [(at, volts) for at, volts in found if volts is not None]


def weeks_since_charge(measured: Sequence[tuple[datetime, float]]) -> int | None:
    """How many weeks before the last check the cell was charged last; None where the checks do not tell: they are so
    far apart that a charge is not seen or its week is not known, a rise is too small to be sure, or it was less than a
    week."""
    for (before_at, before_v), (at, volts) in reversed(list(pairwise(measured))):
        if volts - before_v >= CHARGED_V:
            weeks = round((measured[-1][0] - at) / WEEK)
            return weeks if weeks and at - before_at <= WEEK else None
        if volts - before_v > STEADY_V or at - before_at > 2 * WEEK:
            return None
    return None
