"""Says that an earlier run left a module ACTIVE, until that module, known by its name, reports LOCKED."""

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QObject, Signal

from app.engine.device import How
from app.engine.worker import Batch
from app.safety.last_known import Activation
from app.store.fact_store import Facts, Store
from app.store.left_active import LeftActive
from app.store.store_journal import left_active, new_run, note_continued, note_locked, note_report
from app.text.i18n import tr
from ui.core.background_task import BackgroundTask
from ui.services.port import Port, Ports
from ui.services.storage import ORIGIN
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


class LeftActiveWatch(QObject):
    """Watches the reports of all ports. What is left ACTIVE is derived from the audit log alone; a report that differs
    from it is added there. `changed`: there is another notice."""

    changed = Signal()

    def __init__(self, connector: Ports) -> None:
        super().__init__(connector)
        self._connector, self._storage = connector, connector.storage
        self._is_loaded = False
        self._logging: BackgroundTask[tuple[LeftActive, ...]] = BackgroundTask("dps-s left active", self)
        self._seen: dict[Port, tuple[LeftActive, bool]] = {}
        """What each reported last, unless it is in doubt which module it is, and whether it was active."""
        self._broken: dict[Port, tuple[int, int]] = {}
        """Breaks and restarts until then."""
        for connection in connector.connections:
            self._add(connection)
        connector.added.connect(self._add)
        connector.removed.connect(self._on_removed)

    def load(self) -> None:
        """Once the store is open."""
        self._is_loaded = True
        self._update(lambda _facts: None)

    def notice(self) -> Notice | None:
        """In the language in use; None while the module itself, or its LOCK or link, says it."""
        ports = [port for port in self._connector.connections if port.is_requested]
        entries = self._storage.left_active
        left = next((entry for entry in entries if not any(self._is_at(port, entry) for port in ports)), None)
        if left is None:
            return None
        act = partial(self._update, partial(note_locked, left=left, origin=ORIGIN))
        locked = Choice("left_active_locked", tr("It is locked"), act, is_step=True)
        return Notice(Meaning.ATTENTION, left.sentence, (*self._here_choices(left), locked))

    def _here_choices(self, left: LeftActive) -> tuple[Choice, ...]:
        """A person who has read the label can say that it is the connected one, which then speaks for itself."""
        port, name = self._connector.current, left.known_as.name
        here, _is_active = self._seen.get(port, (None, False))
        is_new = port.target is None or port.adapter_key != port.target.key  # a person said so
        if is_new or here is None or port.module.name or here.known_as != port.known_as:
            return ()  # or none has reported, it is in doubt which it is, or it has a name
        choose = partial(port.module.choose, name)
        goes_on = partial(self._update, partial(note_continued, left=left, here=here, origin=ORIGIN))
        text = tr("It is {module}", module=name) if name else tr("Same module")
        return (Choice("left_active_here", text, choose if name else goes_on, is_step=True),)

    def _is_at(self, port: Port, left: LeftActive) -> bool:
        if left.known_as.run == port.kept.run:
            return True
        is_said = port.activation.state is Activation.ACTIVE or (port is self._connector.current and port.is_active)
        return is_said and left.known_as.name == port.module.name != ""

    def _update(self, note: Callable[[Facts], object]) -> None:
        """Does this in the store's thread, and takes what is left ACTIVE then."""
        store = self._storage.store
        if isinstance(store, Store):
            # Where the store is in trouble, its own notice says it.
            self._logging.run_in(store, partial(_after, note), self._take, lambda _trouble: None)

    def _take(self, left: tuple[LeftActive, ...]) -> None:
        self._storage.left_active = left
        self.changed.emit()

    def _add(self, connection: Port) -> None:
        connection.batch.connect(partial(self._on_batch, connection))
        connection.invalidated.connect(self._on_another_module)

    def _on_removed(self, connection: Port) -> None:
        for known in (self._seen, self._broken):
            known.pop(connection, None)
        self._on_another_module()

    def _on_another_module(self) -> None:
        if self._is_loaded:  # else the store is still being opened
            self.load()

    def _on_batch(self, connection: Port, batch: Batch) -> None:
        known, target = batch.device.known("active", batch.at), connection.target
        if known is None or known.is_stale or known.how is How.ACKNOWLEDGED or target is None or target.is_simulated:
            return
        is_active, broken = known.value is True, (batch.device.breaks, batch.device.restarts)
        if not is_active and self._may_be_exchanged(connection, *broken):
            connection.kept.run = new_run()  # what it reports is not the active one's, until a person says so
        self._broken[connection] = broken
        here = LeftActive(connection.known_as, target.device, target.identity)
        if here.known_as.is_in_doubt:
            self._seen.pop(connection, None)  # LOCK may stay unconfirmed meanwhile
        if here.known_as.is_in_doubt or (here, is_active) == self._seen.get(connection):
            return
        self._seen[connection] = here, is_active
        self._update(partial(note_report, here=here, origin=ORIGIN, is_active=is_active))

    def _may_be_exchanged(self, connection: Port, breaks: int, restarts: int) -> bool:
        """A module without a name, active before a break of less than a second, reports otherwise: neither a restart
        nor LOCK explains it."""
        _here, was_active = self._seen.get(connection, (None, False))
        seen_breaks, seen_restarts = self._broken.get(connection, (breaks, restarts))
        is_broken = breaks != seen_breaks and restarts == seen_restarts
        is_locked = connection.lock.is_repeating or connection.lock.confirmed is not None
        return was_active and is_broken and not connection.module.name and not is_locked


def _after(note: Callable[[Facts], object], facts: Facts) -> tuple[LeftActive, ...]:
    note(facts)
    return left_active(facts)
