"""Files a reading of trigger records unless it may belong to another module."""

from dataclasses import dataclass

from app.engine.identity import went_back
from app.procedures.history import History
from app.records.check_store import CheckStore, Visit
from app.store.store import Store


@dataclass(frozen=True, slots=True)
class TriggersReading:
    """What the module keeps now. `boot_count` None: it did not say."""

    history: History
    boot_count: int | None


@dataclass(frozen=True, slots=True)
class Doubtful:
    """It may be another module: nothing was kept. `boot_count`: of the last visit, where the present one is lower."""

    boot_count: int | None


@dataclass(frozen=True, slots=True)
class Filing:
    """One reading on its way into the store. `is_same_module`: a person says so."""

    store: Store
    reading: TriggersReading
    name: str
    adapter: str
    port: str
    is_same_module: bool

    def run(self) -> Visit | Doubtful:
        """In the store's own thread. Raises `StoreTrouble`."""
        store, reading = self.store, self.reading
        history, checks = reading.history, CheckStore(store.database)
        slots = [one.raw for one in history.records]
        with store.database.together():
            known = store.module_named(self.name)
            if known is not None and not self.is_same_module:
                past = checks.past(known.id, self.name, slots, is_confirmed=history.is_confirmed)
                is_lower = went_back(past.boot_count, reading.boot_count)
                if is_lower or not past.is_same_module:
                    return Doubtful(past.boot_count if is_lower else None)
            module = store.meet_module(self.name, self.adapter)
            return checks.visit(
                module.id,
                slots,
                port=self.port,
                boot_count=reading.boot_count,
                is_confirmed=history.is_confirmed,
            )
