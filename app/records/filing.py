"""Turns evidence into a filed record: judged against the module's history, signed, kept.

Used by the window and the command line. Where the store fails, the verdict and the record are still made.
"""

import logging
from collections.abc import Iterable
from dataclasses import replace
from datetime import UTC, datetime
from typing import NamedTuple

from app.engine.identity import IdentityEvidence, went_back
from app.engine.target import is_simulated
from app.guided.guided_store import last_tests
from app.limits.past import LastTested, Past
from app.limits.service import DueService, due_services, repack_due
from app.preflight.evidence import Evidence
from app.preflight.findings import Case, CheckResult, Person
from app.preflight.module_checks import FINGERPRINT_KEYS, RecordsWord, records_word
from app.preflight.verdict import Assessment, assess
from app.records.check_store import CheckStore
from app.records.record import Record, SignedRecord, make_record, sign
from app.settings.profiles import Profile
from app.stations.station import own_station
from app.store.database import StoreTrouble
from app.store.facts import FactKind
from app.store.fired import Fired, all_fired, claim_fired, unnamed_fired
from app.store.station_names import introduce
from app.store.store import Store
from app.system.folders import data_folder
from app.system.wall_clock import age_days
from app.text.messages import clean
from app.text.user_error import UserError
from protocol.translatable import marked

_log = logging.getLogger(__name__)
SERVICES = "services:{module}"
"""Key of a state: what other stations did to this module, "done", as the archive has it, each with its "station"."""


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
    instead."""
    name = clean(person.module.strip()) if person.module is not None and person.module.strip() else None
    at, adapter = local_now(), adapter or evidence.port
    trouble: UserError | None = None
    if past is None:
        past = Past(module=name)
        try:
            if store is not None:
                past = _past(store, name, evidence, adapter, at)
        except StoreTrouble as error:
            trouble = error
    assessment = assess(Case(evidence=evidence, profile=profile, past=past, person=replace(person, module=name)))
    record = make_record(assessment, at=at, adapter=adapter)
    try:
        station = own_station(data_folder() if store is None else store.database.path.parent)
    except UserError as error:
        _log.warning("The record is not signed: %s", error)
        return Filed(assessment, record, None, trouble or error)
    signed = sign(record, station)
    if store is not None and trouble is None:
        try:
            _keep(store, assessment, signed)
        except StoreTrouble as error:
            trouble = error
    return Filed(assessment, record, signed, trouble)


def _past(store: Store, name: str | None, evidence: Evidence, adapter: str, at: datetime) -> Past:
    """Checks and guided tests of a simulated module never count for a real one."""
    fired = unnamed_fired(store.facts, port=evidence.port, adapter=adapter)
    if name is None:  # one without a name that fired at this port may be this one
        due = repack_due(max((one.at for one in fired), default=None), ())
        return Past(due=() if due is None else (due,))
    history = evidence.history
    slots = None if history is None else [record.raw for record in history.records]
    is_confirmed, counts_simulated = history is not None and history.is_confirmed, is_simulated(evidence.port)
    tests = last_tests(store.facts, name, counts_simulated=counts_simulated)
    checks, known = CheckStore(store.database), store.evidence(name)
    past = checks.past(name, slots, is_confirmed=is_confirmed, counts_simulated=counts_simulated)
    has_newer = None not in (past.boot_count, known.boot_count) and not went_back(past.boot_count, known.boot_count)
    return replace(
        past,
        boot_count=known.boot_count if has_newer else past.boot_count,
        settings=known.settings,
        tests={kind: LastTested(test, age_days(test.at, at)) for kind, test in tests.items()},
        due=service_due(store, name, at, simulated=counts_simulated, more=fired),
    )  # fmt: skip


def service_due(
    store: Store, name: str, at: datetime, *, simulated: bool = False, more: Iterable[Fired] = ()
) -> list[DueService]:
    """What a person has to do to the module of this name; `simulated`: to a simulated one. `more`: what fired and is
    not under its name yet. Raises `StoreTrouble`."""
    kept = store.facts.select(FactKind.SERVICE, "AND module = ? ORDER BY number", (name,))
    done = [fact.content for fact in kept]
    fired = [one.at for one in (*all_fired(store.facts, name), *more) if one.is_simulated is simulated]
    repack = repack_due(max(fired, default=None), [(fact.at, fact.content) for fact in kept])
    # What another station did may end a warning, and never what a verdict rests on.
    others = store.facts.state(SERVICES.format(module=name)) or {}
    done += others.get("done", ())
    due = due_services(sorted(done, key=lambda content: str(content["on"])), at.date())
    return due if repack is None else [repack, *due]


def _keep(store: Store, assessment: Assessment, signed: SignedRecord) -> None:
    """As one piece. Raises `StoreTrouble`."""
    name, checks = assessment.case.person.module, CheckStore(store.database)
    evidence = assessment.case.evidence
    history, boots = evidence.history, evidence.values.get("boot_count")
    # The records may be another module's: they must not become part of this one's history.
    is_one_module = assessment.result("undisturbed") is CheckResult.PASS
    is_one_module &= assessment.result("boot_count") is not CheckResult.FAIL
    with store.database.transaction():
        if name is not None:
            store.register_module(name)
            is_one_module &= not checks.is_kept_apart(name, evidence.port)
        introduce(store.facts, signed.station)
        checks.add_check(signed)
        if name is not None and is_one_module:
            claim_fired(store.facts, name, port=evidence.port, adapter=signed.record.adapter)
        if history is None or not is_one_module:
            return
        now = IdentityEvidence(None if boots is None else int(boots), evidence.settings(FINGERPRINT_KEYS))
        slots = [record.raw for record in history.records]
        checks.store_visit(
            name, slots, port=evidence.port, boot_count=now.boot_count, is_confirmed=history.is_confirmed
        )
        if name is not None:
            if assessment.case.person.is_same_module and now.is_complete:
                store.store_evidence(name, now)
            _keep_word(checks, name, assessment.case)


def _keep_word(checks: CheckStore, name: str, case: Case) -> None:
    """Keeps what a person said of the records: they are reviewed, or the module is new, until it reports a trigger."""
    history, word = case.evidence.history, records_word(case) if case.person.are_records_reviewed else None
    if any(status.triggered for status in case.evidence.statuses):
        checks.say_new(name, is_new=False)
    elif word is RecordsWord.NEW_MODULE:
        checks.say_new(name)
    if history is not None and word is RecordsWord.REVIEWED:
        checks.mark_reviewed(name, [record.raw for record in history.records])
