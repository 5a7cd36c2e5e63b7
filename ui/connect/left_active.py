"""Says at the start which module was left ACTIVE, until that module, known by its name, reports LOCKED."""

from datetime import datetime
from functools import partial

from PySide6.QtCore import QObject, Signal

from app.engine.device import How
from app.engine.worker import Batch
from app.safety.last_known import Activation, keep_away
from app.store.database import StoreTrouble
from app.store.left_active import LeftActive, left_active, note_locked, note_report
from app.store.store import Store
from app.text.i18n import tr
from app.text.sentences import join_sentences
from ui.core.connector import Connector
from ui.core.port_connection import PortConnection
from ui.services.module_name import ModuleName
from ui.services.storage import ORIGIN, Storage
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


class LeftActiveWatch(QObject):
    """Watches the reports of all ports. What is left ACTIVE is derived from the audit log alone; a report that differs
    from it is added there. `changed`: there is another notice."""

    changed = Signal()

    def __init__(self, connector: Connector, storage: Storage, naming: ModuleName, parent: QObject) -> None:
        super().__init__(parent)
        self._connector, self._storage, self._naming = connector, storage, naming
        self._left: list[LeftActive] = []
        """Of former runs of the program."""
        self._seen: dict[PortConnection, tuple[str, bool]] = {}
        for connection in connector.connections:
            self._add(connection)
        connector.added.connect(self._add)
        connector.removed.connect(lambda connection: self._seen.pop(connection, None))

    def load(self) -> None:
        """Once the store is open."""
        store = self._storage.store
        try:
            self._left = list(left_active(store)) if isinstance(store, Store) else []
        except StoreTrouble:
            self._left = []  # the notice about the store says it
        self.changed.emit()

    def notice(self) -> Notice | None:
        """In the language in use; None while the module itself reports that it is active."""
        is_active = self._connector.activation.state is Activation.ACTIVE
        shown = self._naming.name if is_active else ""
        left = next((one for one in self._left if not shown or one.module != shown), None)
        if left is None:
            return None
        when = datetime.fromisoformat(left.at).astimezone().strftime("%Y-%m-%d %H:%M")
        module = left.module or tr("The module at {port}", port=left.port)
        text = (
            tr("{module}: LOCK not confirmed on {time}.", module=module, time=when)
            if left.is_lock_unconfirmed
            else tr("{module} was left ACTIVE on {time}.", module=module, time=when)
        )
        locked = Choice("left_active_locked", tr("It is locked"), partial(self._end, left), is_step=True)
        return Notice(Meaning.ATTENTION, join_sentences((text, keep_away())), (locked,))

    def _add(self, connection: PortConnection) -> None:
        connection.batch.connect(partial(self._on_batch, connection))

    def _on_batch(self, connection: PortConnection, batch: Batch) -> None:
        known, target = batch.device.known("active", batch.at), connection.target
        if known is None or known.is_stale or known.how is How.ACKNOWLEDGED or target is None or target.is_simulated:
            return
        if not connection.identity.is_proven:
            self._seen.pop(connection, None)
            return
        seen = self._naming.of(connection).name, known.value is True
        if seen == self._seen.get(connection):
            return
        self._seen[connection] = seen
        name, is_active = seen
        store = self._storage.store
        if isinstance(store, Store):
            where = {"port": target.device, "adapter": target.identity, "module": name, "origin": ORIGIN}
            store.queue.submit(partial(note_report, store, **where, is_active=is_active))
        if not is_active and name:
            self._drop([one for one in self._left if one.module == name])

    def _end(self, left: LeftActive) -> None:
        """A person says that it is locked or switched off."""
        store = self._storage.store
        if isinstance(store, Store):
            store.queue.submit(partial(note_locked, store, left, ORIGIN))
        self._drop([left])

    def _drop(self, ended: list[LeftActive]) -> None:
        if ended:
            self._left = [one for one in self._left if one not in ended]
            self.changed.emit()
