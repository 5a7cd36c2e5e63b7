"""Turns evidence into a filed record: judged against the module's history, signed, kept.

Used by the window and the command line. Where the store fails, the verdict and the record are still made.
"""

import logging
from collections import Counter
from concurrent.futures import CancelledError
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from app.engine.target import is_simulated
from app.guided.guided_store import last_tests
from app.limits.past import LastTested, Past
from app.modules.names import remember, remembered
from app.modules.service import repack_due, service_due
from app.preflight.evidence import Evidence
from app.preflight.findings import Case, CheckResult, Person
from app.preflight.module_checks import FINGERPRINT_KEYS, RecordsWord, records_word
from app.preflight.verdict import Assessment, assess
from app.records.checks import checks_in, keep_record
from app.records.record import Record, SignedRecord, make_record, sign
from app.settings.profiles import Profile
from app.stations.station import own_station
from app.store.fact_store import Facts, Store
from app.store.fired import claim_fired, unnamed_fired
from app.store.trouble import StoreFault, StoreTrouble
from app.system.folders import data_folder
from app.system.wall_clock import age_days
from app.text.messages import clean
from app.text.user_error import UserError
from app.trigger_records.kept import KeptTriggers
from protocol.translatable import marked

_log = logging.getLogger(__name__)


class Filed(NamedTuple):
    """`signed` is None where the key of this station cannot be used. `trouble`: why the record was not kept."""

    assessment: Assessment
    record: Record
    signed: SignedRecord | None
    trouble: UserError | None = None

    @property
    def exported(self) -> SignedRecord:
        """What may leave this computer. Raises `UserError` where it could not be signed."""
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
    name = _name_of(person)
    trouble: UserError | None = None
    if past is None:
        past = Past(module=name)
        if store is not None:
            try:
                past = store.read(lambda facts: _past(facts, name, evidence, adapter, at))
            except StoreTrouble as error:
                trouble = error
    folder = data_folder() if store is None else store.folder
    filed = judge_check(evidence, profile, person, past, folder=folder, adapter=adapter, at=at)
    if store is None or trouble is not None or filed.signed is None:
        return filed._replace(trouble=trouble or filed.trouble)
    try:
        store.write(lambda facts: keep_check(facts, filed)).result()
    except StoreTrouble as error:
        return filed._replace(trouble=error)
    except CancelledError:  # the store was closed meanwhile
        return filed._replace(trouble=StoreTrouble(StoreFault.FAILED, store.path, "closed"))
    return filed


def judge_check(
    evidence: Evidence, profile: Profile, person: Person, past: Past, *, folder: Path, adapter: str, at: datetime
) -> Filed:
    """Judges and signs a check; it is not kept yet. `folder`: of this station's key."""
    person = replace(person, module=_name_of(person))
    assessment = assess(Case(evidence=evidence, profile=profile, past=past, person=person))
    record = make_record(assessment, at=at, adapter=adapter)
    try:
        return Filed(assessment, record, sign(record, own_station(folder)))
    except UserError as error:
        _log.warning("The record is not signed: %s", error)
        return Filed(assessment, record, None, error)


def keep_check(facts: Facts, filed: Filed) -> None:
    """Within `Store.write`."""
    signed = filed.exported
    assessment = filed.assessment
    evidence = assessment.case.evidence
    history = evidence.history
    boots = evidence.values.get("boot_count")
    name = assessment.case.person.module
    triggers = KeptTriggers(facts)
    # The records may be another module's: they must not become part of this one's history.
    is_one_module = assessment.result("connection") is CheckResult.PASS
    is_one_module &= assessment.result("boot_count") is not CheckResult.FAIL
    if name is not None:
        remember(facts, name)
        is_one_module &= not triggers.is_kept_apart(name, evidence.port)
    keep_record(facts, signed)
    if name is None or not is_one_module:
        return
    claim_fired(facts, name, port=evidence.port, adapter=signed.record.adapter)
    if history is None:
        return
    boot_count = None if boots is None else int(boots)
    slots = [record.raw for record in history.records]
    triggers.store_visit(name, slots, port=evidence.port, boot_count=boot_count, is_confirmed=history.is_confirmed)
    remember(facts, name, boot_count=boot_count, settings=evidence.settings(FINGERPRINT_KEYS))
    _keep_word(triggers, name, assessment.case)


def _name_of(person: Person) -> str | None:
    return clean(person.module.strip()) if person.module is not None and person.module.strip() else None


def _past(facts: Facts, name: str | None, evidence: Evidence, adapter: str, at: datetime) -> Past:
    """Checks and guided tests of a simulated module never count for a real one."""
    fired = unnamed_fired(facts, port=evidence.port, adapter=adapter)
    if name is None:  # one without a name that fired at this port may be this one
        due = repack_due(max((one.at for one in fired), default=None), ())
        return Past(due=() if due is None else (due,))
    history = evidence.history
    slots = None if history is None else [record.raw for record in history.records]
    is_confirmed = history is not None and history.is_confirmed
    counts_simulated = is_simulated(evidence.port)
    tests = last_tests(facts, name, counts_simulated=counts_simulated)
    triggers = KeptTriggers(facts)
    counted = [check for check in checks_in(facts, name) if counts_simulated or not check.is_simulated]
    passed = next((check for check in counted if check.has_passed), None)
    judged = [record.raw for record in triggers.records(name) if record.judgement is not None]
    return Past(
        module=name,
        remembered=remembered(facts, name),
        reviewed=Counter(judged),
        has_check=passed is not None,
        do_records_follow=slots is None or triggers.do_follow(name, slots, is_confirmed=is_confirmed),
        last_answer=triggers.last_answer(name),
        is_said_new=triggers.is_said_new(name),
        fingerprint=None if passed is None else passed.code,
        tests={kind: LastTested(test, age_days(test.at, at)) for kind, test in tests.items()},
        due=service_due(facts, name, at, simulated=counts_simulated, more=fired),
    )


def _keep_word(triggers: KeptTriggers, name: str, case: Case) -> None:
    """Keeps what a person said of the records: they are reviewed, or the module is new, until it reports a trigger."""
    history = case.evidence.history
    word = records_word(case) if case.person.are_records_reviewed else None
    if any(status.triggered for status in case.evidence.statuses):
        triggers.say_new(name, is_new=False)
    elif word is RecordsWord.NEW_MODULE:
        triggers.say_new(name)
    if history is not None and word is RecordsWord.REVIEWED:
        triggers.mark_reviewed(name, [record.raw for record in history.records])
