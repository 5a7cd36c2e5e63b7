"""Offers to find the module after an unfinished change of baud rate, at the next start."""

from collections.abc import Callable
from functools import partial

from app.engine.target import Target
from app.engine.worker import Job
from app.procedures.baud import end_found
from app.procedures.find import look_for
from app.store.database import StoreTrouble
from app.store.store import PendingBaud, Store
from app.text.i18n import tr
from ui.core.background_task import BackgroundTask
from ui.core.connector import Connector
from ui.core.port_watcher import PortWatcher
from ui.services.storage import Storage
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


class BaudRecovery:
    """`close` dismisses the notice, `leave` asks before it leaves the connected module, `say` shows the result."""

    def __init__(
        self,
        connector: Connector,
        ports: PortWatcher,
        storage: Storage,
        *,
        close: Callable[[], None],
        leave: Callable[[Callable[[], object]], None],
        say: Callable[[str], None],
    ) -> None:
        self._connector, self._ports, self._storage = connector, ports, storage
        self._close, self._leave, self._say = close, leave, say
        self._writing: BackgroundTask[None] = BackgroundTask("dps-s baud rate", connector)

    def pending(self) -> tuple[PendingBaud, ...]:
        store = self._storage.store
        try:
            return store.pending_bauds() if isinstance(store, Store) else ()
        except StoreTrouble:
            return ()

    def notice(self, pending: PendingBaud) -> Notice:
        """The notice in the language in use."""
        text = tr(
            "Changing {port} from {old} to {new} baud was interrupted: it may be at either.",
            old=pending.old_rate, new=pending.new_rate, port=pending.port,
        )  # fmt: skip
        begin = partial(self._leave, partial(self._search, pending))
        look = Choice("look_for_baud", tr("Find my module"), begin, is_main=True)
        forget = Choice("forget_baud", tr("Dismiss"), lambda: self._discard(pending), is_step=True)
        return Notice(Meaning.ATTENTION, text, (look, forget))

    def _search(self, pending: PendingBaud) -> None:
        same = [port.device for port in self._ports.ports if pending.adapter and port.identity == pending.adapter]
        device = same[0] if len(same) == 1 else pending.port
        self._close()
        self._connector.connect_to(Target(device, pending.new_rate, pending.adapter))

        def end(job: Job[int | None]) -> None:
            found = None if job.run.error is not None else job.outcome()
            if found is None:
                self._say(tr("Not found. Switch the module off and on, then “Find my module”."))
                return
            self._settle(pending, end_found(pending.old_rate, pending.new_rate, found).value)
            self._say(tr("The module answers at {rate} baud.", rate=found))

        self._connector.run(look_for(pending.new_rate, pending.old_rate), end)

    def _discard(self, pending: PendingBaud) -> None:
        self._settle(pending, "forgotten")
        self._close()

    def _settle(self, pending: PendingBaud, end: str) -> None:
        store = self._storage.store
        if isinstance(store, Store):
            settle = partial(store.settle_baud, pending.id, end)
            self._writing.run_in(store.queue, settle, lambda _none: None, lambda trouble: self._say(trouble.sentence))
