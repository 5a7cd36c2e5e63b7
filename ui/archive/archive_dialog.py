"""Archive dialog: server, exchange, and the state and history of every module."""

from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QHBoxLayout, QLabel, QLineEdit, QPushButton, QSplitter, QVBoxLayout, QWidget

from app.archive.module_history import HistoryEvent, module_history
from app.archive.report import ModuleToday, report
from app.records.verification import shown_key
from app.store.kinds import Serviced
from app.system.wall_clock import MINUTE, local_time
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import join_sentences
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.archive.archive_exchange import ArchiveExchange, Seen, archive_of, exchanged_text
from ui.archive.service_form import ServiceForm
from ui.core.background_task import BackgroundTask
from ui.files.file_dialogs import ThenPath, ask_path, show_over_page
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn, select_row
from ui.services.context import Services
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import control, named, set_role
from ui.widgets.labels import text_label

SUFFIX: Final = ".dps-s"
_ROW_PX: Final = 26
_SHOWN_LEFT_OUT: Final = 3


def _verdict(row: ModuleToday) -> str:
    check = row.last_check
    return tr("none") if check is None else f"{local_time(check.at, MINUTE)} {check.words.translated()}"


def _verdict_ink(row: ModuleToday) -> Meaning | None:
    return Meaning.DANGER if row.last_check is not None and not row.last_check.holds else None


_MODULE_COLUMNS: Final = (
    TableColumn[ModuleToday](marked("Module"), lambda row: clean(row.name)),
    TableColumn[ModuleToday](marked("Last check"), _verdict, ink=_verdict_ink),
    TableColumn[ModuleToday](marked("Trigger records"), lambda row: str(row.trigger_records)),
    TableColumn[ModuleToday](
        marked("Due"),
        lambda row: row.due_words,
        ink=lambda row: Meaning.ATTENTION if row.due else None,
        stretches=True,
    ),
)
_HISTORY_COLUMNS: Final = (
    TableColumn[HistoryEvent](marked("Time"), lambda event: local_time(event.row.made_at, MINUTE)),
    TableColumn[HistoryEvent](marked("Station"), lambda event: shown_key(event.row.station)[:9]),
    TableColumn[HistoryEvent](marked("Record"), lambda event: event.text.translated(), stretches=True),
)


class ArchiveDialog(QDialog):
    """Not modal, so that LOCK stays reachable. Files and the server are accessed in a background thread."""

    def __init__(self, exchange: ArchiveExchange, services: Services, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("archive_dialog")
        self.setWindowTitle(tr("Archive of all stations"))
        self.setAccessibleName(tr("Archive of all stations"))
        self._exchange = exchange
        self._services = services
        self.ask_file: Callable[[QWidget, ThenPath], object] = _ask_file
        self._loading: BackgroundTask[list[ModuleToday]] = BackgroundTask("dps-s archive list", self)
        self._loading_history: BackgroundTask[list[HistoryEvent]] = BackgroundTask("dps-s archive life", self)
        self._keeping: BackgroundTask[object] = BackgroundTask("dps-s archive service", self)
        self.server = control(QLineEdit(), "archive_server", says=tr("Server"), tip=tr("Without the password"))
        self.server.setPlaceholderText("postgresql://USER@HOST/DATABASE?sslrootcert=system")
        self.sync = control(QPushButton(tr("Sync now")), "archive_sync", picture=Icon.AGAIN, slot=self._sync)
        self.server.returnPressed.connect(self.sync.click)
        self.state = text_label("archive_state", is_selectable=True)
        self.service = control(
            QPushButton(tr("Service…")), "archive_service", picture=Icon.CLOCK, slot=self._ask_service
        )
        self.carry = control(
            QPushButton(tr("Exchange with a file…")), "archive_file", picture=Icon.FOLDER, slot=self._choose_file
        )
        self.modules = RowsTable(
            "archive_modules",
            tr("Modules"),
            _MODULE_COLUMNS,
            lambda row: row.name,
            lambda row: f"{clean(row.name)}: " + (row.due_words or tr("nothing due")),
            row_px=_ROW_PX,
            is_single=True,
        )
        self.life = RowsTable(
            "archive_life",
            tr("Records"),
            _HISTORY_COLUMNS,
            lambda event: event.row.id,
            lambda event: event.text.translated(),
            row_px=_ROW_PX,
            is_single=True,
        )
        label = named(QLabel(tr("Server")), "archive_server_label")
        label.setBuddy(self.server)
        place = QHBoxLayout()
        for widget in (label, self.server, self.sync):
            place.addWidget(widget)
        actions = QHBoxLayout()
        actions.addWidget(self.state, 1)
        actions.addWidget(self.service)
        actions.addWidget(self.carry)
        tables = named(QSplitter(Qt.Orientation.Vertical), "archive_split")
        tables.addWidget(self.modules)
        tables.addWidget(self.life)
        column = QVBoxLayout(self)
        column.setContentsMargins(Space.L, Space.L, Space.L, Space.L)
        column.addLayout(place)
        column.addLayout(actions)
        column.addWidget(tables, 1)
        self.modules.selectionModel().selectionChanged.connect(lambda _new, _old: self._show_life())
        exchange.changed.connect(self._refresh)

    def bring_up(self) -> None:
        show_over_page(self, is_large=True)
        self._exchange.exchange(None)
        self._refresh()

    def _sync(self) -> None:
        """With the server whose address stands there; none, where it is empty."""
        try:
            self._exchange.use_server(self.server.text())
        except UserError as error:
            self._fail(error)
            return
        self.server.setText(self._exchange.server or "")  # without its password

    def _choose_file(self) -> None:
        self.ask_file(self, lambda path: self._exchange.exchange(str(path)))

    def _ask_service(self) -> None:
        for module in self.modules.chosen():
            keep = partial(self._keep_service, module.name)
            ServiceForm(self, clean(module.name), self._services.preferences.who, keep)

    def _keep_service(self, module: str, service: Serviced) -> None:
        storage = self._services.storage
        self._keeping.run(
            lambda _running: archive_of(storage).store.add(service, module).result(),
            lambda _kept: self._exchange.exchange(None),
            self._fail,
        )

    def _refresh(self) -> None:
        """What is known of the exchange now; the modules are read again once it has ended."""
        is_free = not self._exchange.is_running
        self.sync.setEnabled(is_free)
        self.carry.setEnabled(is_free)
        if not self.server.isModified():
            self.server.setText(self._exchange.server or "")
        if not is_free:
            self._say(tr("Exchanging…"))
            return
        self._say(*_state(self._exchange.seen))
        if self.isVisible():
            storage = self._services.storage
            self._loading.run(lambda _running: report(archive_of(storage), datetime.now(UTC)), self._show, self._fail)

    def _say(self, text: str, role: str = "") -> None:
        self.state.setText(text)
        set_role(self.state, role)

    def _show(self, modules: list[ModuleToday]) -> None:
        """The chosen one stays chosen, also where others came to it."""
        names = [row.name for row in self.modules.chosen()]
        self.modules.show_rows(modules)
        self.modules.choose(lambda row: row.name in names)
        if modules and not self.modules.chosen():
            select_row(self.modules, 0)
        self._show_life()

    def _show_life(self) -> None:
        chosen = self.modules.chosen()
        self.service.setEnabled(bool(chosen))
        if not chosen:
            self.life.show_rows(())
            return
        name, storage = chosen[0].name, self._services.storage
        self._loading_history.run(
            lambda _running: module_history(archive_of(storage), name)[::-1], self.life.show_rows, self._fail
        )

    def _fail(self, error: Exception) -> None:
        if not isinstance(error, UserError):
            raise error
        self._say(error.sentence, "attention")


def _state(seen: Seen) -> tuple[str, str]:
    """As a sentence, and its role in the style sheet."""
    if seen.trouble is not None:
        return seen.trouble.translated(), "attention"
    parts = [exchanged_text(seen)]
    done = seen.done
    if done is not None:
        parts.append(tr("Sent: {sent}. Received: {received}.", sent=done.sent, received=done.received))
        if done.left_out_count:
            parts.append(tr("Left out, unreadable or altered: {count}.", count=done.left_out_count))
            parts += [f"{one.id[:12]}: {one.why}." for one in done.left_out[:_SHOWN_LEFT_OUT]]
            return join_sentences(parts), "attention"
    return join_sentences(parts) or tr("No server is set."), ""


def _ask_file(parent: QWidget, then: ThenPath) -> None:
    """One that is there gets what it lacks, and gives what this station lacks."""
    suggested = Path.home() / f"archive{SUFFIX}"
    ask_path(parent, tr("Exchange with a file…"), suggested, f"*{SUFFIX}", then, is_extended=True)
