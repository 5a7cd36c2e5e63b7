"""Name of the connected module, given once by a technician and used on every page, and the field to type it in."""

import logging
from collections.abc import Callable
from functools import partial
from math import inf

from PySide6.QtCore import QObject, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QFocusEvent
from PySide6.QtWidgets import QComboBox, QLineEdit

from app.engine.identity import Expected, IdentityEvidence, evidence_of
from app.engine.target import Target
from app.engine.worker import Batch, PortState
from app.settings.identity_words import known_by
from app.store.database import StoreTrouble
from app.store.store import Module, Store
from app.store.store_journal import KnownAs
from app.text.i18n import tr
from app.text.messages import clean
from ui.core.background_task import BackgroundTask
from ui.core.connector import Connector
from ui.core.port_connection import PortConnection
from ui.core.texts import Texts
from ui.services.storage import Storage
from ui.widgets.controls import named
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

_log = logging.getLogger(__name__)
MAX_NAME_LENGTH = 60
STORE_AGAIN_S = 1.0
BeforeNew = Callable[[Callable[[], object]], object]
"""Calls what it is given, perhaps after a question."""


class PortModule(QObject):
    """Name of the module on one port.

    `changed`: the name changed or was cleared. The name never follows the adapter by itself: at each connection, and
    after each break of the conversation, the module has no name until a person says that it is the expected one.
    """

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.name = ""
        self.expected_name = ""
        """Name of the expected module, while it is not proven that it is the one that answers."""
        self.before_new: BeforeNew = _at_once
        """Called before what was known of the expected module is dropped."""
        self._connector: PortConnection | None = None
        self._storage: Storage | None = None
        self._adapter = ""
        self._read: dict[str, IdentityEvidence] = {}
        """What was last read of the modules of this session, by name."""
        self._stored: dict[str, IdentityEvidence] = {}
        """The part of `_read` that is in the store."""
        self._tried_at = -inf
        self._identifying: BackgroundTask[None] = BackgroundTask("dps-s module", self)
        self._saving: BackgroundTask[bool] = BackgroundTask("dps-s evidence", self)

    def bind(self, connector: PortConnection, storage: Storage) -> None:
        self._connector, self._storage = connector, storage
        connector.expect(self._expected_at)
        connector.changed.connect(self._watch_identity)
        connector.batch.connect(self._on_batch)
        self._watch_identity()

    @property
    def known(self) -> tuple[Module, ...]:
        """All modules of the store, the last seen first; empty if there is no store."""
        store = self._store
        if store is None:
            return ()
        try:
            return store.modules()
        except StoreTrouble as trouble:
            _log.warning("The names of the modules cannot be read: %s", trouble)
            return ()

    def choose(self, name: str) -> None:
        """An empty or unchanged name answers no question: a field says it whenever it loses the focus."""
        name = clean(name.strip(), longest=MAX_NAME_LENGTH)
        connector = self._connector
        if name == self.name:
            return
        if connector is not None and connector.is_open and not connector.identity.is_settled:
            if name and name == self.expected_name:
                self.confirm_identity()
            elif name:
                self.before_new(partial(self._begin_new, name))
        else:
            self._use(name)
            if connector is not None and connector.is_open:
                connector.confirm_identity(connector.identity, is_named=bool(name))

    def confirm_identity(self) -> None:
        """A person confirms that it is the expected module."""
        if self._connector is not None:
            self._connector.confirm_identity(self._connector.identity)

    def treat_as_new(self) -> None:
        """A person says that it is another module; it has no name yet."""
        if self._connector is not None:
            self.before_new(partial(self._begin_new, ""))

    def _begin_new(self, name: str) -> None:
        self.expected_name = name  # it is the name as soon as the engine knows, too
        if self._connector is not None:
            self._connector.treat_as_new(is_named=bool(name))

    @property
    def adapter(self) -> str:
        """Key of the adapter or port of the module."""
        return self._adapter

    def remember_adapter(self) -> None:
        """Store the adapter and what was read of the module, so that it is recognised when plugged in again."""
        store, evidence = self._store, self._read.get(self.name)
        if store is not None and self.name:
            self._identifying.run_in(
                store.queue,
                partial(_register, store, self.name, self._adapter, evidence),
                lambda _none: None if evidence is not None else self.store_evidence(),
                lambda trouble: _log.warning("The adapter of a module cannot be kept: %s", trouble),
            )

    def store_evidence(self) -> None:
        """Store what was last read of the module of this name, if the module is in the store by then."""
        store, evidence = self._store, self._read.get(self.name)
        if store is not None and evidence is not None and not self._saving.is_running:
            self._saving.run_in(
                store.queue,
                partial(_store_evidence, store, self.name, evidence),
                partial(self._end_saving, self.name, evidence),
                lambda trouble: _log.warning("What was read of a module cannot be kept: %s", trouble),
            )

    @property
    def _store(self) -> Store | None:
        store = self._storage.store if self._storage is not None else None
        return store if isinstance(store, Store) else None

    def _use(self, name: str) -> None:
        if name != self.name:
            self.name = name
            self.changed.emit()

    # Which module it is

    def _expected_at(self, target: Target) -> Expected | None:
        """What was last read of the module that is known at this port; None where none is."""
        if target.key != self._adapter:
            self._adapter = target.key
            self.expected_name = next((one.name for one in self.known if one.adapter == self._adapter), "")
        else:
            self.expected_name = self.name or self.expected_name
        self._use("")
        return Expected(self._evidence_of(self.expected_name)) if self.expected_name else None

    def _evidence_of(self, name: str) -> IdentityEvidence:
        if name in self._read:
            return self._read[name]
        store, module = self._store, next((one for one in self.known if one.name == name), None)
        try:
            return IdentityEvidence() if store is None or module is None else store.evidence(module.name)
        except StoreTrouble as trouble:
            _log.warning("What was last read of a module cannot be read: %s", trouble)
            return IdentityEvidence()

    def _watch_identity(self) -> None:
        connector = self._connector
        if connector is None or connector.target is None:
            return
        if not connector.is_open:
            return
        if not connector.identity.is_settled:
            self.expected_name = self.name or self.expected_name
            self._use("")
        elif self.expected_name:
            meant, self.expected_name = self.expected_name, ""
            self._use(meant)

    # What was last read of it

    def _on_batch(self, batch: Batch) -> None:
        is_module = batch.connection.state is PortState.OPEN and batch.identity.is_settled and bool(self.name)
        if not is_module or self._connector is None:
            return
        evidence = evidence_of(batch.device.values, is_fresh=True)
        if not evidence.is_complete:
            return
        is_new, self._read[self.name] = self._read.get(self.name) != evidence, evidence
        # The store may be opened, and the module be in it, only after the module was read.
        if is_new or (self._stored.get(self.name) != evidence and batch.at - self._tried_at > STORE_AGAIN_S):
            self._tried_at = batch.at
            self.store_evidence()

    def _end_saving(self, name: str, evidence: IdentityEvidence, is_stored: bool) -> None:
        if is_stored:
            self._stored[name] = evidence
        if self._read.get(self.name) != evidence:
            self.store_evidence()


class ModuleName(QObject):
    """Name of the module that the pages show; `of` returns that of any port. `changed` is of the shown one."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._connector: Connector | None = None
        self._storage: Storage | None = None
        self._modules: dict[PortConnection, PortModule] = {}
        self._before_new: BeforeNew = _at_once
        self._shown = PortModule()
        self._shown.setParent(self)
        self._shown.changed.connect(self.changed)

    def bind(self, connector: Connector, storage: Storage) -> None:
        """Called once for a window; further calls do nothing."""
        if self._connector is None:
            self._connector, self._storage = connector, storage
            self._modules[connector.current] = self._shown
            self._shown.bind(connector.current, storage)
            storage.known_at = self._known_at
            connector.added.connect(self.of)
            connector.removed.connect(self._on_removed)
            connector.chosen.connect(self._show)

    def of(self, connection: PortConnection) -> PortModule:
        if connection not in self._modules:
            module = self._modules[connection] = PortModule()
            module.setParent(self)
            if self._storage is not None:
                module.bind(connection, self._storage)
        return self._modules[connection]

    @property
    def name(self) -> str:
        return self._shown.name

    @property
    def expected_name(self) -> str:
        return self._shown.expected_name

    @property
    def known(self) -> tuple[Module, ...]:
        return self._shown.known

    @property
    def adapter(self) -> str:
        return self._shown.adapter

    @property
    def known_by(self) -> str:
        """By what the shown module is known, in the language in use; "" without a connection."""
        is_open = self._connector is not None and self._connector.current.is_open
        return known_by(self.name).translated() if is_open else ""

    def choose(self, name: str) -> None:
        self._shown.choose(name)

    def confirm_identity(self) -> None:
        self._shown.confirm_identity()

    def treat_as_new(self) -> None:
        self._shown.treat_as_new()

    def before_new(self, ask: BeforeNew) -> None:
        """`ask` is called before the shown module is treated as another one."""
        self._before_new = self._shown.before_new = ask

    def remember_adapter(self) -> None:
        self._shown.remember_adapter()

    def store_evidence(self) -> None:
        self._shown.store_evidence()

    def _known_at(self, target: Target) -> KnownAs:
        at = ((port, module.name) for port, module in self._modules.items() if port.target == target)
        return next((known_as(port, name) for port, name in at), KnownAs())

    def _show(self) -> None:
        if self._connector is not None:
            self._shown.changed.disconnect(self.changed)
            self._shown.before_new = _at_once
            self._shown = self.of(self._connector.current)
            self._shown.before_new = self._before_new
            self._shown.changed.connect(self.changed)
            self.changed.emit()

    def _on_removed(self, connection: PortConnection) -> None:
        module = self._modules.pop(connection, None)
        if module is not None:
            module.deleteLater()


def known_as(port: PortConnection, name: str) -> KnownAs:
    return KnownAs(name, port.kept.run, is_in_doubt=not port.identity.is_settled)


def _at_once(act: Callable[[], object]) -> None:
    act()


def _register(store: Store, name: str, adapter: str, evidence: IdentityEvidence | None) -> None:
    """Runs in the store's thread, as one piece of work: the window may be closed afterwards."""
    store.register_module(name, adapter)
    if evidence is not None:
        store.store_evidence(name, evidence)


def _store_evidence(store: Store, name: str, evidence: IdentityEvidence) -> bool:
    """Runs in the store's thread, after the module was stored; False if it was not."""
    module = store.module_named(name)
    if module is not None:
        store.store_evidence(name, evidence)
    return module is not None


def module_label(name: str) -> str:
    """For sentences, in the language in use."""
    return name or tr("a module without a name")


class _NameEdit(QLineEdit):
    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Another program that comes to the front interrupts whoever types; it ends no editing."""
        self.blockSignals(event.reason() is Qt.FocusReason.ActiveWindowFocusReason)
        super().focusOutEvent(event)
        self.blockSignals(False)


class ModuleField(QComboBox):
    """A name to type or choose, applied by Enter, by choosing, or by leaving the field for another of the window."""

    def __init__(self, name: str, naming: ModuleName, texts: Texts, guard: WheelGuard) -> None:
        super().__init__()
        named(self, name)
        self._naming = naming
        self.setEditable(True)
        self.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.setMinimumContentsLength(8)
        self.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        guard.guard(self)
        self._edit = edit = _NameEdit()
        self.setLineEdit(edit)
        self.setCompleter(None)  # type: ignore[arg-type]  # it would make M-12 of a typed M-1
        edit.setObjectName(f"{name}_edit")
        edit.setMaxLength(MAX_NAME_LENGTH)
        edit.editingFinished.connect(self._apply)
        self.activated.connect(self._apply)
        texts.bind(self.setAccessibleName, "Module")
        texts.bind(edit.setAccessibleName, "Module")
        texts.bind(edit.setPlaceholderText, "not named")
        texts.bind(self.setToolTip, "Without a serial number its name identifies it")
        naming.changed.connect(self.show_name)
        VisibilityTimer(self, self.show_name)
        self.show_name()

    def show_name(self) -> None:
        if self._edit.isModified():
            return  # somebody types
        with QSignalBlocker(self):
            self.clear()
            self.addItems([one.name for one in self._naming.known])
            self.setCurrentIndex(self.findText(self._naming.name, Qt.MatchFlag.MatchExactly))
            self.setEditText(self._naming.name)

    def _apply(self) -> None:
        self._naming.choose(self.currentText())
        self._edit.setModified(False)
        self.show_name()
