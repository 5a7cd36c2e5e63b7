"""Files a reading of trigger records unless it may belong to another module."""

from collections.abc import Iterable
from dataclasses import dataclass

from app.engine.identity import IdentityEvidence, Trust, same_module, went_back
from app.limits.expectations import Past
from app.procedures.history import History
from app.records.check_store import CheckStore, Visit
from app.store.store import Store


def past_of(store: Store, name: str) -> Past:
    """What is known of the module of this name. Raises `StoreTrouble`."""
    return CheckStore(store.database).past(name)


def say_new(store: Store, names: Iterable[str]) -> None:
    """Keeps a person's word that these modules are new and have no records. Raises `StoreTrouble`."""
    with store.database.transaction():
        for name in names:
            store.register_module(name)
            CheckStore(store.database).say_new(name)


@dataclass(frozen=True, slots=True)
class TriggersReading:
    """The records on the module. `boot_count` is None where it did not answer."""

    history: History
    boot_count: int | None


@dataclass(frozen=True, slots=True)
class PossiblyOther:
    """It may be another module, so nothing was stored. `boot_count`: of the last visit, where it is lower now."""

    boot_count: int | None


def file_triggers(
    store: Store, reading: TriggersReading, name: str, *, adapter: str, port: str, is_same_module: bool
) -> Visit | PossiblyOther:
    """`is_same_module`: confirmed by a person. To be called in the store's thread. Raises `StoreTrouble`."""
    history, checks = reading.history, CheckStore(store.database)
    slots = [one.raw for one in history.records]
    with store.database.transaction():
        known = store.module_named(name)
        if known is not None and not is_same_module:
            past = checks.past(name, slots, is_confirmed=history.is_confirmed)
            before, now = IdentityEvidence(past.boot_count), IdentityEvidence(reading.boot_count)
            trust = same_module(before, now, do_records_follow=past.do_records_follow, is_said=True)
            if trust is not Trust.PROVEN:
                is_lower = went_back(past.boot_count, reading.boot_count)
                return PossiblyOther(past.boot_count if is_lower else None)
        store.register_module(name, adapter)
        return checks.store_visit(
            name, slots, port=port, boot_count=reading.boot_count, is_confirmed=history.is_confirmed
        )
