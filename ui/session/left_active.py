"""Says which modules were left ACTIVE, until each is known to be safe. See `app.safety.left_active` for the rules."""

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QObject, Signal

from app.engine.conversation import How
from app.safety.left_active import LeftActive, all_left
from app.store.acts import note_report, note_said_safe
from app.store.fact_store import Facts
from app.text.i18n import tr
from ui.core.background_task import BackgroundTask
from ui.services.storage import ORIGIN
from ui.session.port import Port
from ui.session.ports import Ports
from ui.style.theme import Meaning
from ui.widgets.notices import Choice, Notice


class LeftActiveWatch(QObject):
    """Keeps in the store what the modules on all ports report, and shows what is left of ended conversations."""

    # There is another notice.
    changed = Signal()

    def __init__(self, ports: Ports) -> None:
        super().__init__(ports)
        self._ports, self._storage = ports, ports.storage
        self._writing: BackgroundTask[tuple[LeftActive, ...]] = BackgroundTask("dps-s left active", self)
        # What the store was told last of the conversation at each port.
        self._told: dict[Port, tuple[object, ...]] = {}
        for port in ports.all:
            self._add(port)
        ports.added.connect(self._add)

    def load(self) -> None:
        """Load what was left ACTIVE, once the store is open."""
        self._update(lambda _facts: None)

    def notices(self) -> list[Notice]:
        """The last one first."""
        going = {port.module.run_id for port in self._ports.all if port.module.is_going}
        notices = []
        for left in self._storage.left_active:
            if left.run not in going:
                act = partial(self._update, partial(note_said_safe, left=left, origin=ORIGIN))
                safe = Choice("left_active_locked", tr("It is safe"), act, is_step=True)
                meaning = Meaning.ATTENTION if left.is_warning else Meaning.INFORMATION
                notices.append(Notice(meaning, left.sentence, (safe,), cause=f"left {left.run}"))
        return notices

    def _add(self, port: Port) -> None:
        port.changed.connect(partial(self._watch, port))
        port.module_changed.connect(self.changed)

    def _watch(self, port: Port) -> None:
        """A report that differs from what the store was told of this conversation."""
        module, where = port.module, port.module.where
        known = module.view.values.get("active")
        if known is None or known.how is How.ACKNOWLEDGED or where is None:
            return
        is_active = known.value is True
        told = (module.run_id, module.name, module.is_going, is_active)
        # One that is LOCKED counts only while its conversation goes on: afterwards that is what it reported last.
        if told != self._told.get(port) and (is_active or module.is_going):
            self._told[port] = told
            self._update(partial(note_report, where=where, is_active=is_active))

    def _update(self, note: Callable[[Facts], object]) -> None:
        """Do this in the store's thread, and take what is left ACTIVE then."""

        def work(facts: Facts) -> tuple[LeftActive, ...]:
            note(facts)
            return all_left(facts)

        store = self._storage.ready
        if store is not None:
            # Where the store is in trouble, its own notice says it.
            self._writing.run_in(store, work, self._take, lambda _trouble: None)

    def _take(self, left: tuple[LeftActive, ...]) -> None:
        self._storage.left_active = left
        self.changed.emit()
