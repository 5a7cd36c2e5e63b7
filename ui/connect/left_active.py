"""Says what an earlier run left: a module ACTIVE, until that module, known by its name, reports LOCKED; or a change of
baud rate that was interrupted."""

from collections.abc import Callable, Mapping
from functools import partial

from PySide6.QtCore import QObject, Signal

from app.engine.device import How
from app.engine.target import Target
from app.engine.worker import Batch, Job
from app.procedures.baud import logged_later
from app.procedures.find import look_for
from app.safety.journal import Outcome
from app.safety.last_known import Activation
from app.settings.identity_words import same_module_words
from app.store.database import StoreTrouble
from app.store.left_active import LeftActive, left_active, note_continued, note_locked, note_report
from app.store.store import PendingBaud, Store
from app.store.store_journal import new_run
from app.text.i18n import tr
from app.text.sentences import join_sentences
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
        self._update(lambda _store: None)

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

    def _update(self, note: Callable[[Store], object]) -> None:
        """Does this in the store's thread, and takes what is left ACTIVE then."""
        store = self._storage.store
        if isinstance(store, Store):
            # Where the store is in trouble, its own notice says it.
            self._logging.run_in(store.queue, partial(_after, note, store), self._take, lambda _trouble: None)

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


def _after(note: Callable[[Store], object], store: Store) -> tuple[LeftActive, ...]:
    note(store)
    return left_active(store)


class BaudRecovery(QObject):
    """`close` dismisses the notice, `ask` shows one about the connected module, `leave_port` asks before it leaves it,
    `say` shows the result."""

    def __init__(
        self,
        connector: Ports,
        *,
        close: Callable[[], None],
        ask: Callable[[Callable[[], Notice]], None],
        leave_port: Callable[[Callable[[], object]], None],
        say: Callable[[str], None],
    ) -> None:
        super().__init__(connector)
        self._connector, self._storage = connector, connector.storage
        self._close, self._ask, self._leave_port, self._say = close, ask, leave_port, say
        self._writing: BackgroundTask[None] = BackgroundTask("dps-s baud rate", connector)
        self._found: tuple[PendingBaud, Port] | None = None
        """Which port's module answers, until a person says that it is the one of this name."""
        connector.changed.connect(self._settle_found)
        connector.renamed.connect(self._settle_found)

    def pending(self) -> tuple[PendingBaud, ...]:
        store = self._storage.store
        try:
            return store.pending_bauds() if isinstance(store, Store) else ()
        except StoreTrouble:
            return ()

    def notice(self, pending: PendingBaud) -> Notice:
        """The notice in the language in use."""
        begin = partial(self._leave_port, partial(self._search, pending))
        search = Choice("look_for_baud", tr("Find the baud rate"), begin, is_main=True)
        forget = Choice("forget_baud", tr("Dismiss"), lambda: self._discard(pending), is_step=True)
        return Notice(Meaning.ATTENTION, _interrupted(pending), (search, forget))

    def _same_notice(self, pending: PendingBaud, rate: int) -> Notice:
        """Of a module without a name only a person can say that it is this one; else it is asked about again."""

        def end() -> None:
            self._settle(pending, *logged_later(pending.old_rate, pending.new_rate, rate))
            self._close()

        text = join_sentences([_interrupted(pending), _found(rate)])
        same = Choice("baud_of_same", same_module_words(""), end, is_step=True)
        return Notice(Meaning.ATTENTION, text, (same,), self._close)

    def _search(self, pending: PendingBaud) -> None:
        same = [
            port.device for port in self._connector.ports.ports if pending.adapter and port.identity == pending.adapter
        ]
        device = same[0] if len(same) == 1 else pending.port
        self._close()

        def end(job: Job[int | None]) -> None:
            rate = None if job.run.error is not None else job.outcome()
            if rate is None:
                self._say(tr("No answer at any rate. Switch the module off and on, then “Find the baud rate”."))
                return
            self._say(_found(rate))
            if not pending.module:
                self._ask(partial(self._same_notice, pending, rate))
                return
            self._found = pending, self._connector.current
            self._settle_found()

        look = partial(self._connector.run, look_for(pending.new_rate, pending.old_rate), end)
        self._connector.connect_to(Target(device, pending.new_rate, pending.adapter), then=look)

    def _settle_found(self) -> None:
        if self._found is None:
            return
        pending, port = self._found
        if port is not self._connector.current or not port.is_open:
            self._found = None
        elif port.identity.is_settled and pending.module == port.module.name:
            self._found, rate = None, port.connection.baud_rate
            self._settle(pending, *logged_later(pending.old_rate, pending.new_rate, rate))

    def _discard(self, pending: PendingBaud) -> None:
        self._settle(pending, Outcome.UNKNOWN, {"end": "forgotten"})
        self._close()

    def _settle(self, pending: PendingBaud, outcome: Outcome, result: Mapping[str, object]) -> None:
        store = self._storage.store
        if isinstance(store, Store):
            settle = partial(store.settle, pending.id, outcome, result)
            self._writing.run_in(store.queue, settle, lambda _none: None, lambda trouble: self._say(trouble.sentence))


def _interrupted(pending: PendingBaud) -> str:
    return tr(
        "Changing {port} from {old} to {new} baud was interrupted: it may be at either.",
        old=pending.old_rate, new=pending.new_rate, port=pending.port,
    )  # fmt: skip


def _found(rate: int) -> str:
    return tr("The module answers at {rate} baud.", rate=rate)
