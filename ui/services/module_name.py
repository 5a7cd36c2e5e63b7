"""Name of the connected module, given once by a technician and used on every page."""

import logging
from collections.abc import Callable
from functools import partial
from math import inf

from PySide6.QtCore import QObject, Signal

from app.engine.identity import UNKNOWN, Expected, IdentityEvidence, Trust, evidence_of, same_module
from app.engine.target import Target
from app.engine.worker import Batch, PortState
from app.settings.identity_words import known_by
from app.store.fact_store import Facts, Store
from app.store.modules import Module, module_named, modules, register_module, store_evidence
from app.store.modules import evidence_of as kept_evidence
from app.store.trouble import StoreTrouble
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import capitalised, join_sentences, labelled
from ui.core.background_task import BackgroundTask
from ui.core.port_connection import PortConnection
from ui.services.storage import Storage

_log = logging.getLogger(__name__)
STORE_AGAIN_S = 1.0
BeforeNew = Callable[[Callable[[], object]], object]
"""Calls what it is given, perhaps after a question."""


class ModuleName(QObject):
    """Name of the module on one port.

    `changed`: the name changed or was cleared. The name never follows the adapter by itself: at each connection, and
    after each break of the conversation, the module has no name until a person says that it is the expected one.
    """

    changed = Signal()
    broke_in_doubt = Signal()
    """Nobody said yet which module it is, and by now it may be a third one: what was said of it is of none."""

    def __init__(self, port: PortConnection, storage: Storage, before_new: BeforeNew) -> None:
        """`before_new` is called before what was known of the expected module is dropped."""
        super().__init__(port)
        self.name = ""
        self.expected_name = ""
        """Name of the expected module, while it is not proven that it is the one that answers."""
        self._doubted_in: tuple[int, int] | None = None
        """The conversation in which that was last in doubt."""
        self._port, self._storage, self._before_new = port, storage, before_new
        self.adapter = ""
        """Key of the adapter or port of the module."""
        self._read: dict[str, IdentityEvidence] = {}
        """What was last read of the modules of this session, by name."""
        self._given = ("", UNKNOWN)
        """The last name, and what was last read under it before it was given."""
        self._stored: dict[str, IdentityEvidence] = {}
        """The part of `_read` that is in the store."""
        self._tried_at = -inf
        self._identifying: BackgroundTask[None] = BackgroundTask("dps-s module", self)
        self._saving: BackgroundTask[bool] = BackgroundTask("dps-s evidence", self)
        port.changed.connect(self._watch_identity)
        port.batch.connect(self._on_batch)

    @property
    def known_by(self) -> str:
        """By what the module is known, in the language in use; "" without a connection."""
        return known_by(self.name).translated() if self._port.is_open else ""

    @property
    def known(self) -> tuple[Module, ...]:
        """All modules of the store, the last seen first; empty if there is no store."""
        store = self._store
        if store is None:
            return ()
        try:
            return store.read(modules)
        except StoreTrouble as trouble:
            _log.warning("The names of the modules cannot be read: %s", trouble)
            return ()

    def choose(self, name: str) -> None:
        """An empty or unchanged name answers no question: a field says it whenever it loses the focus."""
        name = clean(name.strip())
        port = self._port
        if name == self.name:
            return
        if port.is_open and (self.expected_name or not port.identity.is_settled):
            if name and name != self.expected_name:
                self._before_new(partial(self._begin_new, name))
            elif name and not port.identity.is_settled:  # else the engine has not told of it yet
                self.confirm_identity()
        elif port.is_open:
            self._forget_read(self.name)
            before = self._evidence_of(name)
            if same_module(before, evidence_of(port.device.values, is_fresh=True)) is Trust.REFUTED:
                self.expected_name = name  # asked about, as the engine sees it too
                self._use("")
            else:
                self._use(name)
            port.confirm_identity(port.identity, is_named=bool(name), before=before)
        elif name and port.is_requested and port.connection.state is PortState.CLOSED:
            self._before_new(partial(self._expect_next, name))
        else:
            self._use(name)

    def _expect_next(self, name: str) -> None:
        """While a port is lost, a name is of the module that is plugged in next."""
        self._port.expect_next(self._evidence_of(name))
        self._use(name)

    def confirm_identity(self) -> None:
        self._port.confirm_identity(self._port.identity)

    def treat_as_new(self) -> None:
        """A person says that it is another module, which has no name yet."""
        self._before_new(partial(self._begin_new, ""))

    def _begin_new(self, name: str) -> None:
        self.expected_name = name  # it is the name as soon as the engine knows, too
        self._use("")
        self._port.treat_as_new(is_named=bool(name), before=self._evidence_of(name))

    def remember_adapter(self) -> None:
        """Store the adapter and what was read of the module, so that it is recognised when plugged in again."""
        store, evidence = self._store, self._read.get(self.name)
        if store is not None and self.name:
            self._identifying.run_in(
                store,
                partial(_register, name=self.name, adapter=self.adapter, evidence=evidence),
                lambda _none: None,
                lambda trouble: _log.warning("The adapter of a module cannot be kept: %s", trouble),
            )

    @property
    def _store(self) -> Store | None:
        store = self._storage.store
        return store if isinstance(store, Store) else None

    def _use(self, name: str) -> None:
        if name != self.name:
            if name:
                self._given = (name, self._evidence_of(name))
            self.name = name
            self.changed.emit()

    def _forget_read(self, name: str) -> None:
        """It was given by mistake: of its module is known what was before."""
        given, before = self._given
        if given != name or not name:
            return
        self._given = ("", UNKNOWN)
        self._stored.pop(name, None)
        self._read.pop(name, None)
        if before != UNKNOWN:
            self._read[name] = before
        if (store := self._store) is not None:
            store.write(partial(_store_evidence, name=name, evidence=before))

    # Which module it is

    def expected_at(self, target: Target) -> Expected | None:
        """What was last read of the module that is known at this port; None where none is."""
        if target.key != self.adapter:
            self.adapter = target.key
            self.expected_name = next((module.name for module in self.known if module.adapter == self.adapter), "")
        else:
            self.expected_name = self.name or self.expected_name
        self._use("")
        return Expected(self._evidence_of(self.expected_name)) if self.expected_name else None

    def _evidence_of(self, name: str) -> IdentityEvidence:
        """The store's, where another window or a command may have written since; else what is not kept yet."""
        read, store = self._read.get(name, UNKNOWN), self._store
        if store is None or read != self._stored.get(name, UNKNOWN):
            return read
        try:
            return IdentityEvidence(*store.read(lambda facts: kept_evidence(facts, name)))
        except StoreTrouble as trouble:
            _log.warning("What was last read of a module cannot be read: %s", trouble)
            return read

    def _watch_identity(self) -> None:
        if self._port.target is None or not self._port.is_open:
            return
        if not self._port.identity.is_settled:
            self.expected_name = self.name or self.expected_name
            self._use("")
        elif self.expected_name and self._port.identity.is_named:
            meant, self.expected_name = self.expected_name, ""
            self._use(meant)

    def _watch_doubt(self) -> None:
        before, self._doubted_in = self._doubted_in, None if self._port.identity.is_settled else self._port.conversation
        if before is not None and self._doubted_in not in (None, before):
            self.broke_in_doubt.emit()

    # What was last read of it

    def _on_batch(self, batch: Batch) -> None:
        if self._port.is_open:
            self._watch_doubt()
        identity = batch.identity
        is_module = batch.connection.state is PortState.OPEN and identity.is_settled and identity.is_named and self.name
        if not is_module:
            return
        evidence = evidence_of(batch.device.values, is_fresh=True)
        if not evidence.is_complete:
            return
        is_new, self._read[self.name] = self._read.get(self.name) != evidence, evidence
        # The store may be opened, and the module be in it, only after the module was read.
        if is_new or (self._stored.get(self.name) != evidence and batch.at - self._tried_at > STORE_AGAIN_S):
            self._tried_at = batch.at
            self._store_evidence(self.name, evidence)

    def _store_evidence(self, name: str, evidence: IdentityEvidence) -> None:
        """If the module is in the store by then."""
        store = self._store
        if store is not None and not self._saving.is_running:
            self._saving.run_in(
                store,
                partial(_store_evidence, name=name, evidence=evidence),
                lambda is_stored: self._stored.update({name: evidence} if is_stored else {}),
                lambda trouble: _log.warning("What was read of a module cannot be kept: %s", trouble),
            )


def _register(facts: Facts, name: str, adapter: str, evidence: IdentityEvidence | None) -> None:
    register_module(facts, name, adapter)
    if evidence is not None:
        store_evidence(facts, name, evidence)


def _store_evidence(facts: Facts, name: str, evidence: IdentityEvidence) -> bool:
    """After the module was stored; False if it was not."""
    module = module_named(facts, name)
    if module is not None:
        store_evidence(facts, name, evidence)
    return module is not None


def module_label(name: str) -> str:
    """For sentences, in the language in use."""
    return name or tr("Unnamed")


def not_kept(trouble: StoreTrouble, module: str) -> str:
    """With the name of the module it is of: by the time that a slow store tells, another one may be shown."""
    return labelled(capitalised(module_label(module)), join_sentences((trouble.sentence, tr("Not kept."))))
