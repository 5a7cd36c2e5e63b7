"""All modules ever seen by any station: the last check, what is due, the history, services, and the exchange."""

from collections.abc import Callable
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Final

from PySide6.QtCore import QDate, Qt, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDateEdit,
    QFormLayout,
    QHeaderView,
    QLineEdit,
    QPushButton,
    QSizePolicy,
    QStackedWidget,
    QWidget,
)

from app.archive.module_history import HistoryEvent, as_edits, module_history, settings_changed
from app.archive.report import ModuleToday, report
from app.modules.service import TITLES, ServiceKind, serviced
from app.records.verification import shown_key
from app.settings.values import setting_message
from app.store.kinds import Serviced
from app.system.wall_clock import MINUTE, local_time
from app.text.i18n import tr
from app.text.messages import clean, joined
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.files.file_dialogs import ThenPath, ask_path
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn, select_row
from ui.pages.fleet.archive_exchange import ArchiveExchange, archive_of
from ui.services.context import Services
from ui.style.icons import Icon
from ui.style.theme import Meaning, RowHeight, Space
from ui.widgets.controls import control, named, set_role
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row, scroll_area, stacked
from ui.widgets.sliders import WheelGuard, label_for

SUFFIX: Final = ".dps-s"
MAX_LENGTH: Final = 200
# Proposed; a person decides.
REPACKED_FOR_MONTHS: Final = 6


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


class ArchivePanel(QWidget):
    """Files and the server are accessed in a background thread. `settings_wanted`: the page of the settings, which has
    earlier ones as edits."""

    settings_wanted = Signal()

    def __init__(self, exchange: ArchiveExchange, services: Services) -> None:
        super().__init__()
        self.setObjectName("archive_panel")
        self._exchange = exchange
        self._services = services
        self.ask_file: Callable[[QWidget, ThenPath], object] = _ask_file
        self._loading: BackgroundTask[list[ModuleToday]] = BackgroundTask("dps-s archive list", self)
        self._loading_history: BackgroundTask[list[HistoryEvent]] = BackgroundTask("dps-s archive history", self)
        self._keeping: BackgroundTask[object] = BackgroundTask("dps-s archive service", self)
        self.server = control(QLineEdit(), "archive_server", says=tr("Server"), tip=tr("Without the password"))
        self.server.setPlaceholderText("postgresql://USER@HOST/DATABASE?sslrootcert=system")
        self.sync = control(QPushButton(tr("Sync now")), "archive_sync", picture=Icon.AGAIN, slot=self._sync)
        self.server.returnPressed.connect(self.sync.click)
        self.carry = control(
            QPushButton(tr("Exchange with a file…")), "archive_file", picture=Icon.FOLDER, slot=self._choose_file
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
            lambda row: f"{clean(row.name)}: " + (row.due_words or tr("nothing due")),
            row_px=RowHeight.LIST,
            is_single=True,
        )
        self.life = RowsTable(
            "archive_life",
            tr("Records"),
            _HISTORY_COLUMNS,
            lambda event: event.row.id,
            lambda event: event.text.translated(),
            row_px=RowHeight.LIST,
        )
        for table in (self.modules, self.life):
            table.setWordWrap(True)
            table.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.settings = text_label("archive_settings", "small", is_selectable=True)
        self.use = control(
            QPushButton(tr("Use in Settings")), "archive_use", picture=Icon.SETTINGS, slot=self._use_settings
        )
        self.service = ServiceForm(self._keep_service)
        self._lay_out()
        self.service.closed.connect(lambda: self.views.setCurrentIndex(0))
        self.modules.selectionModel().selectionChanged.connect(lambda _new, _old: self._show_history())
        self.life.selectionModel().selectionChanged.connect(lambda _new, _old: self._compare())
        exchange.changed.connect(self._refresh)

    def _lay_out(self) -> None:
        place = in_row(label_for(self.server, tr("Server")), self.server, self.sync)
        state = in_row((self.state, 1), self.carry, self.enter_service)
        chosen = in_row((self.settings, 1), self.use)
        tables = named(QWidget(), "archive_tables")
        in_column((self.modules, 1), chosen, (self.life, 1), of=tables, margins=0)
        self.views = named(QStackedWidget(), "archive_views")
        # The tables scroll by themselves: the page need not be as high as they would like to be.
        self.views.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Ignored)
        stacked(self.views, tables, scroll_area(self.service, "service_scroll", tr("Service…"), is_vertical=True))
        in_column(place, state, (self.views, 1), of=self, margins=(0, Space.S, 0, 0))

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._exchange.exchange(None)
        self._refresh()

    # The exchange, and all modules

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

    def _refresh(self) -> None:
        """What is known of the exchange now; the modules are read again once it has ended."""
        is_free = not self._exchange.is_running
        self.sync.setEnabled(is_free)
        self.carry.setEnabled(is_free)
        if not self.server.isModified():
            self.server.setText(self._exchange.server or "")
        state = self._exchange.state
        self._say(state.sentence if is_free else tr("Exchanging…"), needs_attention=is_free and state.needs_attention)
        if is_free and self.isVisible():
            storage = self._services.storage
            self._loading.run(lambda _running: report(archive_of(storage), datetime.now(UTC)), self._show, self._fail)

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

    def _show_history(self) -> None:
        """The newest first."""
        chosen = self.modules.chosen()
        self.enter_service.setEnabled(bool(chosen))
        if not chosen:
            self._show_events([])
            return
        name, storage = chosen[0].name, self._services.storage
        self._loading_history.run(
            lambda _running: module_history(archive_of(storage), name)[::-1], self._show_events, self._fail
        )

    def _show_events(self, events: list[HistoryEvent]) -> None:
        self.life.show_rows(events)
        self._compare()

    def _compare(self) -> None:
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
        """As edits; nothing is sent."""
        for event in self.life.chosen():
            if event.settings and self._services.exchange.can_use():
                self._services.exchange.used.emit(as_edits(event.settings))
                self.settings_wanted.emit()
                return

    def _enter_service(self) -> None:
        for module in self.modules.chosen():
            self.service.begin(module.name, self._services.preferences.who)
            self.views.setCurrentIndex(1)

    def _keep_service(self, module: str, service: Serviced) -> None:
        self._keeping.run(
            lambda _running: archive_of(self._services.storage).store.add(service, module).result(),
            lambda _kept: self._exchange.exchange(None),
            self._fail,
        )


def _ask_file(parent: QWidget, then: ThenPath) -> None:
    """One that is there gets what it lacks, and gives what this station lacks."""
    suggested = Path.home() / f"archive{SUFFIX}"
    ask_path(parent, tr("Exchange with a file…"), suggested, f"*{SUFFIX}", then, is_extended=True)


class ServiceForm(QWidget):
    """What was done to a module: repacked, ejector, cell, firmware. `keep` gets it with the module's name."""

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
            form.addRow(self.is_due if name == "due" else label, control(field, f"service_{name}", says=label))
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
        due = _date_of(self.due) if self.is_due.isChecked() else None
        kind = ServiceKind(self.kind.currentData())
        service = serviced(kind, on=_date_of(self.on), due=due, who=self.who.text(), note=self.note.text())
        self._keep(self.module, service)
        self.closed.emit()


def _date_of(day: QDateEdit) -> date:
    return date.fromisoformat(day.date().toString(Qt.DateFormat.ISODate))
