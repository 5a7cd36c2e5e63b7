"""Which module this is. It has no serial number: a technician names it once, and every page goes by that name."""

import logging

from PySide6.QtCore import QEvent, QObject, QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QComboBox, QLineEdit

from app.i18n import tr
from app.preflight.wording import clean
from app.store.database import StoreTrouble
from app.store.store import Module, Store
from ui.connector import Connector
from ui.keeping import Keeping
from ui.named import named
from ui.simulator_controls import WheelGuard
from ui.texts import Texts

_log = logging.getLogger(__name__)
LONGEST_NAME = 60


class ModuleName(QObject):
    """`changed`: it is another name now, or none. At another adapter it is the module that was last seen there."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.name = ""
        self._connector: Connector | None = None
        self._keeping: Keeping | None = None
        self._adapter = ""

    def follow(self, connector: Connector, keeping: Keeping) -> None:
        """Once for a window; a second time does nothing."""
        if self._connector is None:
            self._connector, self._keeping = connector, keeping
            connector.changed.connect(self._watch_adapter)
            self._watch_adapter()

    @property
    def known(self) -> tuple[Module, ...]:
        """All modules of the store, the last seen first; none where there is no store."""
        store = self._store
        if store is None:
            return ()
        try:
            return store.modules()
        except StoreTrouble as trouble:
            _log.warning("The names of the modules cannot be read: %s", trouble)
            return ()

    @property
    def module_id(self) -> int | None:
        """In the store; None for a name that is not in it yet."""
        return next((one.id for one in self.known if one.name == self.name), None)

    def choose(self, name: str) -> None:
        name = clean(name.strip(), longest=LONGEST_NAME)
        if name != self.name:
            self.name = name
            self.changed.emit()

    def meet(self) -> Module | None:
        """The module of this name, in the store from now on. Raises `StoreTrouble`."""
        store = self._store
        return store.meet_module(self.name, self._adapter) if store is not None and self.name else None

    @property
    def _store(self) -> Store | None:
        store = self._keeping.store if self._keeping is not None else None
        return store if isinstance(store, Store) else None

    def _watch_adapter(self) -> None:
        target = self._connector.target if self._connector is not None else None
        if target is None or target.key == self._adapter:
            return
        self._adapter = target.key
        self.choose(next((one.name for one in self.known if one.adapter == self._adapter), ""))


class ModuleField(QComboBox):
    """A name to type or to choose; it counts when the field is left, at Enter, or when one is chosen."""

    def __init__(self, name: str, naming: ModuleName, texts: Texts, guard: WheelGuard) -> None:
        super().__init__()
        named(self, name)
        self._naming = naming
        self.setEditable(True)
        self.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.setMinimumContentsLength(8)
        self.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        guard.guard(self)
        edit = QLineEdit()
        self.setLineEdit(edit)
        edit.setObjectName(f"{name}_edit")
        edit.setMaxLength(LONGEST_NAME)
        edit.editingFinished.connect(self._take)
        self.activated.connect(self._take)
        texts.bind(self.setAccessibleName, "Name of the module")
        texts.bind(edit.setAccessibleName, "Name of the module")
        texts.bind(edit.setPlaceholderText, "not named yet")
        texts.bind(self.setToolTip, "The module has no serial number: name it once, and it is known again")
        naming.changed.connect(self.show_name)
        self.show_name()

    def show_name(self) -> None:
        with QSignalBlocker(self):
            self.clear()
            self.addItems([one.name for one in self._naming.known])
            self.setCurrentIndex(self.findText(self._naming.name, Qt.MatchFlag.MatchExactly))
            self.setEditText(self._naming.name)

    def _take(self) -> None:
        self._naming.choose(self.currentText())
        self.setEditText(self._naming.name)

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Show:
            self.show_name()
        return super().event(event)


def whose(name: str) -> str:
    """For sentences, in the language in use."""
    return name or tr("a module without a name")
