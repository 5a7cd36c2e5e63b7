"""All modules ever seen by any station, the exchange with them, and what was done to each."""

from collections.abc import Callable
from datetime import UTC, date, datetime
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QDate, QTimer, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDateEdit,
    QFormLayout,
    QLineEdit,
    QPushButton,
    QSizePolicy,
    QStackedWidget,
    QWidget,
)

from app.archive.archive import exchanged, sync
from app.archive.places import server_url
from app.archive.report import HistoryEvent, ModuleToday, as_edits, module_history, report, settings_changed
from app.modules.service import TITLES, serviced
from app.settings.values import setting_message
from app.store.fact_store import Facts, StoreError
from app.store.rows import Serviced, ServiceKind
from app.store.station import shown_key
from app.system.clock import MINUTE, local_time
from app.text.i18n import tr
from app.text.messages import UserError, clean, join_sentences, joined, labelled
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask, Running
from ui.files.file_dialogs import ask_path
from ui.forms.tables import RowsTable, TableColumn, select_row, wrap_rows
from ui.services.context import Services
from ui.services.page import Page
from ui.style.icons import Icon
from ui.style.theme import Meaning, RowHeight, Space
from ui.widgets.controls import control, in_column, in_row, named, scroll_area, set_role, stacked, text_label
from ui.widgets.number_line import WheelGuard, label_for

EXCHANGE_EVERY_MS: Final = 300_000
MAX_LENGTH: Final = 200
# Of a table with its header.
LEAST_ROWS: Final = 4
# Proposed; a person decides.
REPACKED_FOR_MONTHS: Final = 6


def _verdict(row: ModuleToday) -> str:
    check = row.last_check
    return tr("none") if check is None else f"{local_time(check.at, MINUTE)} {check.words.translated()}"


_MODULE_COLUMNS: Final = (
    TableColumn[ModuleToday](marked("Module"), lambda row: clean(row.name)),
    TableColumn[ModuleToday](
        marked("Last check"),
        _verdict,
        ink=lambda row: Meaning.DANGER if row.last_check is not None and not row.last_check.holds else None,
    ),
    TableColumn[ModuleToday](marked("Trigger records"), lambda row: str(row.trigger_records), is_spare=True),
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


class ArchivePanel(QWidget):
    """Exchanges records in a background thread, with a server by itself where one is set: one exchange at a time, and
    the window never waits for it."""

    # The server that is set.
    _server: str | None = None

    def __init__(self, services: Services, page: Page) -> None:
        super().__init__()
        self.setObjectName("archive_panel")
        self._services, self._page = services, page
        self.ask_file = ask_path
        self._exchanging: BackgroundTask[tuple[str, bool]] = BackgroundTask("dps-s archive", self)
        timer = QTimer(self, interval=EXCHANGE_EVERY_MS)
        timer.timeout.connect(lambda: self._exchange(self._server) if self._server else None)
        timer.start()
        self._loading: BackgroundTask[list[ModuleToday]] = BackgroundTask("dps-s archive list", self)
        self._loading_history: BackgroundTask[list[HistoryEvent]] = BackgroundTask("dps-s archive history", self)
        self._keeping: BackgroundTask[object] = BackgroundTask("dps-s archive service", self)
        example = "postgresql://USER@HOST/DATABASE"
        tip = labelled(tr("Without the password"), f"{example}?sslrootcert=system")
        self.server = named(QLineEdit(), "archive_server", says=tr("Server"), tip=tip)
        self.server.setPlaceholderText(example)
        self.sync = control(QPushButton(tr("Sync now")), "archive_sync", picture=Icon.AGAIN, slot=self._sync)
        self.server.returnPressed.connect(self.sync.click)
        self.carry = control(
            QPushButton(tr("Exchange with a file…")),
            "archive_file",
            picture=Icon.FOLDER,
            slot=self._choose_file,
        )
        self.state = text_label("archive_state", is_selectable=True)
        self.enter_service = control(
            QPushButton(tr("Service…")), "archive_service", picture=Icon.CLOCK, slot=self._enter_service
        )
        self.modules = RowsTable(
            "archive_modules",
            tr("Modules"),
            _MODULE_COLUMNS,
            lambda row: row.name,
            row_px=RowHeight.LIST,
            is_single=True,
        )
        self.life = RowsTable(
            "archive_life", tr("Records"), _HISTORY_COLUMNS, lambda event: event.row.id, row_px=RowHeight.LIST
        )
        for table in (self.modules, self.life):
            # They scroll by themselves: the page need not be as high as they would like to be.
            table.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Ignored)
            table.setMinimumHeight(LEAST_ROWS * table.verticalHeader().defaultSectionSize())
            wrap_rows(table)
        self.settings = text_label("archive_settings", "small", is_selectable=True)
        self.use = control(
            QPushButton(tr("Use in Settings")), "archive_use", picture=Icon.SETTINGS, slot=self._use_settings
        )
        self.service = ServiceForm(self._keep_service)
        tables = named(QWidget(), "archive_tables")
        in_column((self.modules, 1), in_row((self.settings, 1), self.use), (self.life, 1), of=tables, margins=0)
        self.views = named(QStackedWidget(), "archive_views")
        stacked(self.views, tables, scroll_area(self.service, "service_scroll", tr("Service…"), is_vertical=True))
        place = in_row(label_for(self.server, tr("Server")), self.server, self.sync)
        state = in_row((self.state, 1), self.carry, self.enter_service)
        in_column(place, state, (self.views, 1), of=self, margins=(0, Space.S, 0, 0))
        self.service.closed.connect(lambda: self.views.setCurrentIndex(0))
        self.modules.selectionModel().selectionChanged.connect(self._show_history)
        self.life.selectionModel().selectionChanged.connect(self._compare)
        services.storage.opened.connect(self._start)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._exchange(None)

    # The exchange, and all modules

    def _start(self) -> None:
        store = self._services.storage.ready
        self._server = None if store is None else store.state("server")
        self.server.setText(self._server or "")
        if self._server is not None or self.isVisible():
            self._exchange(self._server)

    def _sync(self) -> None:
        """Exchange with the server whose address stands there, which is kept; with none, where it is empty."""
        typed, store = self.server.text(), self._services.storage.ready
        try:
            self._server = server_url(typed) if typed.strip() else None
        except UserError as error:
            self._say(error.sentence, needs_attention=True)
            return
        self.server.setText(self._server or "")
        if store is not None:
            store.set_state("server", self._server)
        self._exchange(self._server)

    def _choose_file(self) -> None:
        """Exchange with a file: one that is there gets what it lacks, and gives what this station lacks."""
        name, then = Path("archive.dps-s"), lambda path: self._exchange(str(path))
        self.ask_file(self, tr("Exchange with a file…"), name, "*.dps-s", then, is_extended=True)

    def _exchange(self, place: str | None) -> None:
        """Exchange with a server or a file, in both directions; None: count only what is not shared with the server."""
        server, store = self._server, self._services.storage.store
        if self._exchanging.is_running:
            return
        if isinstance(store, StoreError):
            self._say(store.sentence, needs_attention=True)
            return

        def work(_running: Running) -> tuple[str, bool]:
            parts = []
            done = None if place is None else sync(store, place)
            if server is not None:
                last_at, not_shared = exchanged(store, server)
                time = tr("never") if last_at is None else local_time(last_at, MINUTE)
                parts.append(tr("Not shared: {count}. Last: {time}.", count=not_shared, time=time))
            if done is not None:
                parts.append(tr("Sent: {sent}. Received: {received}.", sent=done.sent, received=done.received))
            if done is not None and done.left_out_count:
                parts.append(tr("Left out, unreadable or altered: {count}.", count=done.left_out_count))
                parts += [f"{one.id[:12]}: {one.why}." for one in done.left_out[:3]]
            needs_attention = done is not None and done.left_out_count > 0
            return join_sentences(parts) or tr("No server is set."), needs_attention

        self._exchanging.run(work, self._end_exchange, self._fail_exchange)
        self.sync.setEnabled(False)
        self.carry.setEnabled(False)
        self._say(tr("Exchanging…"), needs_attention=False)

    def _fail_exchange(self, error: Exception) -> None:
        """Say why it failed. An exchange that failed by itself is said wherever a person is."""
        if not isinstance(error, UserError):
            raise error
        self._end_exchange((error.sentence, True))
        self._services.ports.notified.emit(error.sentence)

    def _end_exchange(self, state: tuple[str, bool]) -> None:
        """The modules are read again."""
        self.sync.setEnabled(True)
        self.carry.setEnabled(True)
        self._say(state[0], needs_attention=state[1])
        store = self._services.storage.ready
        if self.isVisible() and store is not None:
            self._loading.run(lambda _running: report(store, datetime.now(UTC)), self._show, self._fail)

    def _say(self, text: str, *, needs_attention: bool) -> None:
        self.state.setText(text)
        set_role(self.state, "attention" if needs_attention else "")

    def _fail(self, error: Exception) -> None:
        if not isinstance(error, UserError):
            raise error
        self._say(error.sentence, needs_attention=True)

    def _show(self, modules: list[ModuleToday]) -> None:
        """The chosen one stays chosen, also where others came to it."""
        names = [row.name for row in self.modules.chosen()]
        self.modules.show_rows(modules)
        self.modules.choose(lambda row: row.name in names)
        if modules and not self.modules.chosen():
            select_row(self.modules, 0)
        self._show_history()

    # One module

    def _show_history(self, *_selection: object) -> None:
        """The newest first."""
        chosen, store = self.modules.chosen(), self._services.storage.ready
        self.enter_service.setEnabled(bool(chosen))
        if not chosen or store is None:
            self._show_events([])
            return
        name = chosen[0].name
        self._loading_history.run(lambda _running: module_history(store, name)[::-1], self._show_events, self._fail)

    def _show_events(self, events: list[HistoryEvent]) -> None:
        self.life.show_rows(events)
        self._compare()

    def _compare(self, *_selection: object) -> None:
        """The settings of one entry, or what differs between two, the earlier first."""
        told = sorted((event for event in self.life.chosen() if event.settings), key=lambda event: event.row.made_at)
        text = tr("Choose an entry for its settings, or two with Ctrl to compare them.")
        if len(told) == 1:
            text = joined([setting_message(*one) for one in sorted(told[0].settings.items())]).translated()
        elif told:
            changes = settings_changed(told[0].settings, told[-1].settings)
            text = joined(changes).translated() if changes else tr("The settings are the same.")
        self.settings.setText(text)
        self.use.setEnabled(len(told) == 1 and self._services.exchange.can_use())

    def _use_settings(self) -> None:
        """Fill in the settings as edits; nothing is sent."""
        for event in self.life.chosen():
            if event.settings and self._services.exchange.can_use():
                self._services.exchange.used.emit(as_edits(event.settings))
                self._page.page_wanted.emit("settings")
                return

    def _enter_service(self) -> None:
        for module in self.modules.chosen():
            self.service.begin(module.name, self._services.preferences.who)
            self.views.setCurrentIndex(1)

    def _keep_service(self, module: str, service: Serviced) -> None:
        store = self._services.storage.ready
        if store is not None:
            kept = partial(Facts.add, content=service, module=module)
            self._keeping.run_in(store, kept, lambda _kept: self._exchange(None), self._fail)


class ServiceForm(QWidget):
    """The form of what was done to a module: repacked, ejector, cell, firmware. `keep` gets it with the module's
    name."""

    closed = Signal()

    def __init__(self, keep: Callable[[str, Serviced], object]) -> None:
        super().__init__()
        self.setObjectName("service_form")
        self._keep = keep
        self.module = ""
        self.title = text_label("service_title", "strong")
        self.kind = QComboBox()
        for kind, title in TITLES.items():
            self.kind.addItem(tr(title), kind)
        self.on = QDateEdit()
        self.is_due = named(QCheckBox(tr("Due again on")), "service_is_due")
        self.due = QDateEdit()
        self.is_due.toggled.connect(self.due.setEnabled)
        self.who = QLineEdit(maxLength=MAX_LENGTH)
        self.note = QLineEdit(maxLength=MAX_LENGTH)
        self.save = control(QPushButton(tr("Save")), "service_save", role="primary", slot=self._accept)
        cancel = control(QPushButton(tr("Cancel")), "service_cancel", slot=self.closed)
        form = QFormLayout(self)
        form.addRow(self.title)
        rows = (
            ("kind", tr("What was done"), self.kind),
            ("on", tr("Done on"), self.on),
            ("due", tr("Due again on"), self.due),
            ("who", tr("Done by"), self.who),
            ("note", tr("Note"), self.note),
        )
        for name, label, field in rows:
            form.addRow(self.is_due if name == "due" else label, named(field, f"service_{name}", says=label))
            if isinstance(field, QDateEdit):
                field.setCalendarPopup(True)
                field.setDisplayFormat("yyyy-MM-dd")
            if not isinstance(field, QLineEdit):
                WheelGuard(field)
        form.addRow(in_row(1, cancel, self.save))

    def begin(self, module: str, who: str) -> None:
        """Ask again, for this module."""
        today = QDate.currentDate()
        self.module = module
        self.title.setText(tr("Service of {module}", module=clean(module)))
        self.on.setMaximumDate(today)
        self.on.setDate(today)
        self.due.setMinimumDate(today.addDays(1))
        self.due.setDate(today.addMonths(REPACKED_FOR_MONTHS))
        self.is_due.setChecked(True)
        self.who.setText(who)
        self.note.clear()
        self.kind.setFocus()

    def _accept(self, _is_checked: bool) -> None:
        on, due = (date(day.year(), day.month(), day.day()) for day in (self.on.date(), self.due.date()))
        kind, due_again = ServiceKind(self.kind.currentData()), due if self.is_due.isChecked() else None
        service = serviced(kind, on=on, due=due_again, who=self.who.text(), note=self.note.text())
        self._keep(self.module, service)
        self.closed.emit()
