"""Turns evidence into a filed record: judged against the module's history, sealed, chained.

Used by the window and the command line. Where the store fails, the verdict and the record are still made.
"""

import logging
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
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
from app.records.check_store import CheckStore, MakeRecord
from app.records.record import NOT_STORED, Record, make_record
from app.settings.profiles import Profile
from app.stations.known import Stations
from app.stations.station import Station, own_station
from app.store.database import StoreFault, StoreTrouble
from app.store.facts import FactKind
from app.store.fired import Fired, all_fired, claim_fired, unnamed_fired
from app.store.store import Store
from app.system.folders import data_folder
from app.system.wall_clock import age_days
from app.text.messages import clean
from app.text.user_error import UserError

_log = logging.getLogger(__name__)
SERVICES = "services:{module}"
"""Key of a state: what other stations did to this module, "done", as the archive has it, each with its "station"."""


class Filed(NamedTuple):
    """`trouble`: why the record was not stored. `station_trouble`: why it is not signed."""

    assessment: Assessment
    record: Record
    trouble: StoreTrouble | None = None
    station_trouble: UserError | None = None


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
    """Judges, seals and stores a check, also one that failed or was interrupted. `past`: the module's history before
    the check; None reads it from the store. `adapter`: USB identity of the adapter; where it is "" the port is used
    instead."""
    name = clean(person.module.strip()) if person.module is not None and person.module.strip() else None
    at, adapter = local_now(), adapter or evidence.port
    trouble: StoreTrouble | None = None
    if past is None:
        past = Past(module=name)
        try:
            if store is not None and name is not None:
                with _damage_as_trouble(store):
                    past = _past(store, name, evidence, adapter, at)
        except StoreTrouble as error:
            trouble = error
    case = Case(evidence=evidence, profile=profile, past=past, person=replace(person, module=name))
    assessment = assess(case)
    station, station_trouble = _station(store)

    def make(number: int, previous: str | None) -> Record:
        return make_record(assessment, station, at=at, adapter=adapter, number=number, previous=previous)

    if store is not None and trouble is None:
        try:
            with _damage_as_trouble(store), store.database.transaction():
                record = _store(store, assessment, make, adapter)
            return Filed(assessment, record, None, station_trouble)
        except StoreTrouble as error:
            trouble = error
    return Filed(assessment, make(NOT_STORED, None), trouble, station_trouble)


@contextmanager
def _damage_as_trouble(store: Store) -> Iterator[None]:
    """Raises `StoreTrouble` where the store contains values that cannot be used."""
    try:
        yield
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, OverflowError) as error:
        raise StoreTrouble(StoreFault.DAMAGED, store.database.path, str(error)) from error


def _station(store: Store | None) -> tuple[Station | None, UserError | None]:
    """This station; where its key cannot be used, why the record is not signed."""
    try:
        return own_station(data_folder() if store is None else store.database.path.parent), None
    except UserError as trouble:
        _log.warning("The record is not signed: %s", trouble)
        return None, trouble


def _past(store: Store, name: str, evidence: Evidence, adapter: str, at: datetime) -> Past:
    """Checks and guided tests of a simulated module never count for a real one."""
    fired = unnamed_fired(store.facts, port=evidence.port, adapter=adapter)
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
    with _damage_as_trouble(store):
        kept = store.facts.select(FactKind.SERVICE, "AND module = ? ORDER BY number", (name,))
        done = [fact.content for fact in kept]
        fired = [one.at for one in (*all_fired(store.facts, name), *more) if one.is_simulated is simulated]
        repack = repack_due(max(fired, default=None), [(fact.at, fact.content) for fact in kept])
        others = store.facts.state(SERVICES.format(module=name)) or {}
        revoked = Stations(store.database.path.parent).revoked()
        done += (content for content in others.get("done", ()) if content.get("station") not in revoked)
        due = due_services(sorted(done, key=lambda content: str(content["on"])), at.date())
        return due if repack is None else [repack, *due]


def _store(store: Store, assessment: Assessment, make: MakeRecord, adapter: str) -> Record:
    name, checks = assessment.case.person.module, CheckStore(store.database)
    if name is not None:
        store.register_module(name)
    record = checks.append_check(make, name, adapter=adapter)
    evidence = assessment.case.evidence
    history, boots = evidence.history, evidence.values.get("boot_count")
    # The records may be another module's: they must not become part of this one's history.
    is_one_module = assessment.result("undisturbed") is CheckResult.PASS
    is_one_module &= name is None or not checks.is_kept_apart(name, evidence.port)
    is_one_module &= assessment.result("boot_count") is not CheckResult.FAIL
    if name is not None and is_one_module:
        claim_fired(store.facts, name, port=evidence.port, adapter=adapter)
    if history is not None and is_one_module:
        now = IdentityEvidence(None if boots is None else int(boots), evidence.settings(FINGERPRINT_KEYS))
        slots = [record.raw for record in history.records]
        checks.store_visit(
            name, slots, port=evidence.port, boot_count=now.boot_count, is_confirmed=history.is_confirmed
        )
        if name is not None:
            if assessment.case.person.is_same_module and now.is_complete:
                store.store_evidence(name, now)
            _keep_word(checks, name, assessment.case)
    return record


def _keep_word(checks: CheckStore, name: str, case: Case) -> None:
    """Keeps what a person said of the records: they are reviewed, or the module is new, until it reports a trigger."""
    history, word = case.evidence.history, records_word(case) if case.person.are_records_reviewed else None
    if any(status.triggered for status in case.evidence.statuses):
        checks.say_new(name, is_new=False)
    elif word is RecordsWord.NEW_MODULE:
        checks.say_new(name)
    if history is not None and word is RecordsWord.REVIEWED:
        checks.mark_reviewed(name, [record.raw for record in history.records])
