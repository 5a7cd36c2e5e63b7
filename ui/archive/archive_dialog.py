"""Archive dialog: server, exchange, and the state and history of every module."""

from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QLabel, QLineEdit, QPushButton, QSplitter, QStackedWidget, QWidget

from app.archive.archive import Archive
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
from ui.archive.archive_exchange import ArchiveExchange, Seen, archive_of, last_time
from ui.archive.service_form import ServiceForm
from ui.core.background_task import BackgroundTask
from ui.files.file_dialogs import ThenPath, ask_path, show_over_page
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn, select_row
from ui.services.context import Services
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import control, named
from ui.widgets.labels import EmptyState, IconLabel, text_label
from ui.widgets.layouts import FlowRow, in_column, in_row, stacked
from ui.widgets.visibility_timer import VisibilityTimer

SUFFIX: Final = ".dps-s"
_ROW_PX: Final = 26
_SIGN_PX: Final = 16
_SHOWN_LEFT_OUT: Final = 3


def short_station(key: str) -> str:
    """The beginning of its fingerprint."""
    return shown_key(key)[:9]


def _verdict(row: ModuleToday) -> str:
    return tr("none") if row.last_check is None else row.last_check.words.translated()


def _is_no_go(row: ModuleToday) -> bool:
    return row.last_check is not None and not row.last_check.holds


def _checked_at(row: ModuleToday) -> str:
    return "" if row.last_check is None else local_time(row.last_check.at, MINUTE)


def _accessible_text(row: ModuleToday) -> str:
    return f"{clean(row.name)}: " + (row.due_words or tr("nothing due"))


_MODULE_COLUMNS: Final = (
    TableColumn[ModuleToday](marked("Module"), lambda row: clean(row.name)),
    TableColumn[ModuleToday](marked("Stations"), lambda row: str(len(row.stations))),
    TableColumn[ModuleToday](marked("Last check"), _checked_at),
    TableColumn[ModuleToday](
        marked("Verdict"), _verdict, ink=lambda row: Meaning.DANGER if _is_no_go(row) else None,
        picture=lambda row: icon(Icon.CROSS, Meaning.DANGER) if _is_no_go(row) else None,
    ),
    TableColumn[ModuleToday](marked("Trigger records"), lambda row: row.counted.translated()),
    TableColumn[ModuleToday](
        marked("Due"), lambda row: row.due_words,
        ink=lambda row: Meaning.ATTENTION if row.due else None,
        picture=lambda row: icon(Icon.WARNING, Meaning.ATTENTION) if row.due else None, stretches=True,
    ),
)  # fmt: skip
_HISTORY_COLUMNS: Final = (
    TableColumn[HistoryEvent](marked("Time"), lambda row: local_time(row.row.made_at, MINUTE)),
    TableColumn[HistoryEvent](marked("Station"), lambda row: short_station(row.row.station)),
    TableColumn[HistoryEvent](marked("Record"), lambda row: row.text.translated(), stretches=True),
)


class ArchiveDialog(QDialog):
    """Not modal, so that LOCK stays reachable. Files and the server are accessed in a background thread."""

    def __init__(self, exchange: ArchiveExchange, services: Services, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("archive_dialog")
        self._exchange, self._services = exchange, services
        self.setWindowTitle(tr("Archive of all stations"))
        self.setAccessibleName(tr("Archive of all stations"))
        self.ask_file: Callable[[QWidget, ThenPath], object] = _ask_file
        self._loading: BackgroundTask[list[ModuleToday]] = BackgroundTask("dps-s archive list", self)
        self._loading_history: BackgroundTask[tuple[HistoryEvent, ...]] = BackgroundTask("dps-s archive life", self)
        self.server = control(QLineEdit(), "archive_server", says=tr("Server"), tip=tr("Without the password"))
        self.server.setPlaceholderText("postgresql://USER@HOST/DATABASE?sslrootcert=system")
        self.use = control(QPushButton(tr("Use")), "archive_use_server", slot=self._use_server)
        self.server.returnPressed.connect(self.use.click)
        self.sign = IconLabel("archive_sign", _SIGN_PX)
        self.state = text_label("archive_state", is_selectable=True)
        self.sync = control(QPushButton(tr("Sync now")), "archive_sync", picture=Icon.AGAIN, slot=exchange.sync)
        self.carry = control(
            QPushButton(tr("Exchange with a file…")), "archive_file", picture=Icon.FOLDER, slot=self._choose_file
        )
        label = named(QLabel(tr("Server")), "archive_server_label")
        label.setBuddy(self.server)
        self.service = control(
            QPushButton(tr("Service…")), "archive_service", picture=Icon.CLOCK, slot=self._ask_service
        )
        self.modules = RowsTable(
            "archive_modules",
            tr("Modules"),
            _MODULE_COLUMNS,
            lambda row: row.name,
            _accessible_text,
            row_px=_ROW_PX,
            is_single=True,
        )
        self.life = RowsTable(
            "archive_life",
            tr("Records"),
            _HISTORY_COLUMNS,
            lambda row: row.row.id,
            lambda row: row.text.translated(),
            row_px=_ROW_PX,
            is_single=True,
        )
        self.modules.selectionModel().selectionChanged.connect(lambda _new, _old: self._show_life())
        split = named(QSplitter(Qt.Orientation.Vertical), "archive_split")
        split.addWidget(self.modules)
        split.addWidget(self.life)
        self.empty = EmptyState(
            "archive_empty", Icon.BUNDLE, tr("No modules yet"), tr("Each check or test adds its module.")
        )
        self._views = stacked(named(QStackedWidget(), "archive_views"), split, self.empty)
        actions = FlowRow(right=(self.service, self.sync, self.carry))
        in_column(
            in_row(label, (self.server, 1), self.use, spacing=Space.S),
            in_row(self.sign, (self.state, 1), (actions, 2), spacing=Space.S),
            (self._views, 1),
            of=self, spacing=Space.M, margins=Space.L,
        )  # fmt: skip
        exchange.changed.connect(self._refresh)
        VisibilityTimer(self, self._refresh)
        self._refresh()

    def bring_up(self) -> None:
        show_over_page(self, is_large=True)
        self._exchange.refresh()

    # Actions

    def _use_server(self) -> None:
        try:
            self._exchange.use_server(self.server.text())
        except UserError as error:
            self._show_message(error.sentence, Meaning.ATTENTION)
            return
        self.server.setText(self._exchange.server or "")  # without its password

    def _choose_file(self) -> None:
        self.ask_file(self, lambda path: self._exchange.sync_with(str(path)))

    def _ask_service(self) -> None:
        chosen = self.modules.chosen()
        if chosen:
            services, keep = self._services, partial(self._keep_service, chosen[0].name)
            ServiceForm(self, clean(chosen[0].name), services.preferences.who, keep)

    def _keep_service(self, module: str, content: Serviced) -> None:
        def keep(archive: Archive, _on_page: object) -> None:
            archive.store.add(content, module).result()

        self._exchange.run(keep)

    # Display

    def _refresh(self) -> None:
        exchange, seen = self._exchange, self._exchange.seen
        is_free = not exchange.is_running
        if not self.server.isModified():
            self.server.setText(exchange.server or "")
        self.sync.setEnabled(is_free and exchange.server is not None)
        for button in (self.carry, self.use):
            button.setEnabled(is_free)
        self.service.setEnabled(is_free and bool(self.modules.chosen()))
        if not is_free:
            self._show_message(tr("Exchanging…"), None)
            return
        if seen is not None and seen.trouble is not None:
            self._show_message(seen.trouble.translated(), Meaning.ATTENTION)
        elif seen is not None:
            is_left_out = seen.done is not None and seen.done.left_out_count > 0
            text = _state_text(seen, exchange.server)
            self._show_message(text, Meaning.ATTENTION if is_left_out else None)
        if self.isVisible():
            self._load()

    def _show_message(self, text: str, meaning: Meaning | None) -> None:
        self.state.setText(text)
        self.sign.show_icon(Icon.BUNDLE if meaning is None else Icon.WARNING, meaning, is_muted=meaning is None)

    def _load(self) -> None:
        storage = self._services.storage
        self._loading.run(lambda _running: report(archive_of(storage), datetime.now(UTC)), self._show, self._fail)

    def _show(self, modules: list[ModuleToday]) -> None:
        self.modules.show_rows(modules)
        self._views.setCurrentIndex(0 if modules else 1)
        if modules and not self.modules.selectionModel().hasSelection():
            select_row(self.modules, 0)
        self._show_life()

    def _show_life(self) -> None:
        chosen = self.modules.chosen()
        self.service.setEnabled(not self._exchange.is_running and bool(chosen))
        if not chosen:
            self.life.show_rows(())
            return
        name, storage = chosen[0].name, self._services.storage

        def load() -> tuple[HistoryEvent, ...]:
            history = module_history(archive_of(storage), name)
            return () if history is None else tuple(reversed(history.events))

        self._loading_history.run(lambda _running: load(), self.life.show_rows, self._fail)

    def _fail(self, error: Exception) -> None:
        if not isinstance(error, UserError):
            raise error
        self._show_message(error.sentence, Meaning.ATTENTION)


def _state_text(seen: Seen, server: str | None) -> str:
    parts = []
    if server is not None:
        parts.append(tr("Not shared: {count}. Last: {time}.", count=seen.not_shared, time=last_time(seen.last_at)))
    done = seen.done
    if done is not None:
        parts.append(tr("Sent: {sent}. Received: {received}.", sent=done.sent, received=done.received))
        if done.left_out_count:
            parts.append(tr("Left out, unreadable or altered: {count}.", count=done.left_out_count))
            parts += [f"{one.id[:12]}: {one.why}." for one in done.left_out[:_SHOWN_LEFT_OUT]]
    return join_sentences(parts) or tr("No server is set.")


def _ask_file(parent: QWidget, then: ThenPath) -> None:
    """One that is there gets what it lacks, and gives what this station lacks."""
    suggested = Path.home() / f"archive{SUFFIX}"
    ask_path(parent, tr("Exchange with a file…"), suggested, f"*{SUFFIX}", then, is_extended=True)
