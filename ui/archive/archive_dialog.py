"""Archive dialog: server, exchange, questions about modules, the state and history of every module."""

from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QDialog, QFrame, QLabel, QLineEdit, QPushButton, QSplitter, QStackedWidget, QWidget

from app.archive.archive import Archive
from app.archive.exchange import Exchanged, export_facts, import_facts
from app.archive.fleet_state import ModuleToday, fleet_state
from app.archive.module_history import HistoryEvent, module_history
from app.archive.module_names import Conflict, KnownModule, keep_service, names_of, settle
from app.limits.service import Service
from app.stations.station import shown_station
from app.system.wall_clock import MINUTE, local_time
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import join_sentences
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.archive.archive_exchange import ArchiveExchange, last_time, opened_archive
from ui.archive.service_form import ServiceForm
from ui.core.background_task import BackgroundTask
from ui.files.file_dialogs import ThenPath, ask_open, ask_path, bring_to_front
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn, select_row
from ui.services.context import Services
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, Space, scaled
from ui.widgets.controls import control, named, without_key
from ui.widgets.labels import EmptyState, IconLabel, text_label
from ui.widgets.layouts import FlowRow, in_column, in_row, stacked
from ui.widgets.step_button import StepButton
from ui.widgets.visibility_timer import VisibilityTimer

_ROW_PX: Final = 26


def short_station(public: str) -> str:
    """The beginning of its fingerprint."""
    return shown_station(public)[:9]


def _verdict(row: ModuleToday) -> str:
    return tr("none") if row.last_check is None else row.last_check.words.translated()


def _is_no_go(row: ModuleToday) -> bool:
    return row.last_check is not None and not row.last_check.holds


def _checked_at(row: ModuleToday) -> str:
    return "" if row.last_check is None else local_time(row.last_check.at, MINUTE)


def _accessible_text(row: ModuleToday) -> str:
    return f"{clean(row.module.name)}: " + (row.due_words or tr("nothing due"))


_MODULE_COLUMNS: Final = (
    TableColumn[ModuleToday](marked("Module"), lambda row: clean(row.module.name)),
    TableColumn[ModuleToday](marked("Stations"), lambda row: str(len({station for station, _ in row.module.members}))),
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
    TableColumn[HistoryEvent](marked("Time"), lambda row: local_time(row.fact.made_at, MINUTE)),
    TableColumn[HistoryEvent](marked("Station"), lambda row: short_station(row.fact.station)),
    TableColumn[HistoryEvent](marked("Record"), lambda row: row.text.translated(), stretches=True),
)


FIRST_SIZE: Final = QSize(940, 560)
SUFFIX: Final = ".dpsarchive"
MAX_NAME_LENGTH: Final = 80
_SIGN_PX: Final = 16
_WHO_PX: Final = 160
_LOWEST_PX: Final = 60


class Loaded(NamedTuple):
    states: tuple[ModuleToday, ...]
    conflicts: tuple[Conflict, ...]


class ArchiveDialog(QDialog):
    """Not modal, so that LOCK stays reachable. Files and the server are accessed in a background thread."""

    def __init__(self, exchange: ArchiveExchange, services: Services, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("archive_dialog")
        self.resize(QSize(*map(scaled, FIRST_SIZE.toTuple())).boundedTo(self.screen().availableSize()))
        self._exchange, self._services = exchange, services
        texts = services.texts
        texts.bind(self.setWindowTitle, "Archive of all stations")
        texts.bind(self.setAccessibleName, "Archive of all stations")
        self.ask_save: Callable[[QWidget, ThenPath], object] = _ask_save
        self.ask_open: Callable[[QWidget, ThenPath], object] = _ask_open
        self._loading: BackgroundTask[Loaded] = BackgroundTask("dps-s archive list", self)
        self._loading_history: BackgroundTask[tuple[HistoryEvent, ...]] = BackgroundTask("dps-s archive life", self)
        self._conflicts: tuple[Conflict, ...] = ()
        self.server = control(QLineEdit(), texts, "archive_server", says="Server",
                              tip="Without the password")  # fmt: skip
        self.server.setPlaceholderText("postgresql://USER@HOST/DATABASE?sslrootcert=system")
        self.use = control(QPushButton(), texts, "archive_use_server", "Use",
                           slot=self._use_server)  # fmt: skip
        self.server.returnPressed.connect(self.use.click)
        self.sign = IconLabel("archive_sign", _SIGN_PX)
        self.state = text_label("archive_state", is_selectable=True)
        self.sync = control(QPushButton(), texts, "archive_sync", "Sync now",
                            picture=Icon.AGAIN, slot=exchange.sync)  # fmt: skip
        self.export = control(QPushButton(), texts, "archive_export", "Export…",
                              picture=Icon.SAVE, slot=self._export)  # fmt: skip
        self.import_ = control(QPushButton(), texts, "archive_import", "Import…", picture=Icon.FOLDER,
                               slot=self._import)  # fmt: skip
        label = control(QLabel(), texts, "archive_server_label", "Server")
        label.setBuddy(self.server)
        self._lay_out_question()
        self.service = control(QPushButton(), texts, "archive_service", "Service…", picture=Icon.CLOCK,
                               slot=self._ask_service)  # fmt: skip
        self.modules = RowsTable(texts, "archive_modules", "Modules", _MODULE_COLUMNS, lambda row: row.module.members,
                                 _accessible_text, row_px=_ROW_PX, is_single=True)  # fmt: skip
        self.life = RowsTable(texts, "archive_life", "Records", _HISTORY_COLUMNS, lambda row: row.fact.id,
                              lambda row: row.text.translated(), row_px=_ROW_PX, is_single=True)  # fmt: skip
        self.modules.selectionModel().selectionChanged.connect(lambda _new, _old: self._show_life())
        split = named(QSplitter(Qt.Orientation.Vertical), "archive_split")
        split.addWidget(self.modules)
        split.addWidget(self.life)
        self.empty = EmptyState(
            "archive_empty", Icon.BUNDLE, texts, marked("No modules yet"), marked("Each check or test adds its module.")
        )
        self._views = stacked(named(QStackedWidget(), "archive_views"), split, self.empty)
        self._views.setMinimumHeight(_LOWEST_PX)  # the room is that of a question above
        actions = FlowRow(right=(self.service, self.sync, self.export, self.import_))
        in_column(
            in_row(label, (self.server, 1), self.use, spacing=Space.S),
            in_row(self.sign, (self.state, 1), (actions, 2), spacing=Space.S),
            self.question, (self._views, 1),
            of=self, spacing=Space.M, margins=Space.L,
        )  # fmt: skip
        exchange.changed.connect(self._refresh)
        VisibilityTimer(self, self._refresh, retranslate=self._retranslate)
        self._refresh()

    def bring_up(self) -> None:
        bring_to_front(self)
        self._exchange.refresh()

    def _lay_out_question(self) -> None:
        """One question at a time, with an answer for each name. A decision stays: it takes a deliberate press."""
        texts = self._services.texts
        self.question = named(QFrame(), "archive_question", "card")
        self.asked = text_label("archive_asked")
        self.same = control(StepButton(), texts, "archive_same", says="Same module", slot=lambda: self._settle(0))
        self.same_other = control(StepButton(), texts, "archive_same_other", says="Same module",
                                  slot=lambda: self._settle(1))  # fmt: skip
        self.different = control(
            StepButton(), texts, "archive_different", "Two modules", slot=lambda: self._settle(None)
        )
        sign = IconLabel("archive_question_sign", _SIGN_PX)
        sign.show_icon(Icon.WARNING, Meaning.ATTENTION)
        self.who = control(QLineEdit(self._services.preferences.who), texts, "archive_who", says="Decided by",
                           tip="Decisions are signed with your name")  # fmt: skip
        self.who.setMaxLength(MAX_NAME_LENGTH)
        self.who.setMaximumWidth(_WHO_PX)

        self.who.textChanged.connect(self._refresh_buttons)
        policy = self.same_other.sizePolicy()
        policy.setRetainSizeWhenHidden(False)
        self.same_other.setSizePolicy(policy)
        answers = FlowRow(right=(self.who, self.same, self.same_other, self.different))
        words = in_row(sign, (self.asked, 1), spacing=Space.S)
        in_column(words, answers, of=self.question, spacing=Space.XS, margins=Space.S)
        self.question.hide()

    # Actions

    def _use_server(self) -> None:
        try:
            self._exchange.use_server(self.server.text())
        except UserError as error:
            self._show_message(error.sentence, Meaning.ATTENTION)
            return
        self.server.setText(self._exchange.server or "")  # without its password

    def _export(self) -> None:
        self.ask_save(self, partial(self._carry, export_facts))

    def _import(self) -> None:
        self.ask_open(self, partial(self._carry, import_facts))

    def _carry(self, act: Callable[..., Exchanged], path: Path) -> None:
        self._exchange.run(lambda archive, on_page: act(archive, path, on_page=on_page))

    def _ask_service(self) -> None:
        chosen = self.modules.chosen()
        if chosen:
            services, keep = self._services, partial(self._keep_service, chosen[0].module)
            ServiceForm(self, services.texts, clean(chosen[0].module.name), services.preferences.who, keep)

    def _keep_service(self, module: KnownModule, service: Service) -> None:
        self._exchange.run(lambda archive, _on_page: keep_service(archive, module, service))

    def _settle(self, name_of: int | None) -> None:
        """`name_of`: the module whose name is used for both; None: they are different."""
        if not self._conflicts or self._exchange.is_running:
            return
        first, second = self._conflicts[0].pair
        name = "" if name_of is None else (first, second)[name_of].name
        is_same, who = name_of is not None, self.who.text()

        def act(archive: Archive, _on_page: object) -> None:
            settle(archive, first, second, is_same=is_same, name=name, who=who)

        self._exchange.run(act)
        self._conflicts = self._conflicts[1:]
        self._show_question()

    # Display

    def _refresh(self) -> None:
        exchange, seen = self._exchange, self._exchange.seen
        is_free = not exchange.is_running
        if not self.server.isModified():
            self.server.setText(exchange.server or "")
        self.sync.setEnabled(is_free and exchange.server is not None)
        for button in (self.export, self.import_, self.use):
            button.setEnabled(is_free)
        self.service.setEnabled(is_free and bool(self.modules.chosen()))
        self._refresh_buttons()
        if not is_free:
            self._show_message(tr("Exchanging…"), None)
            return
        if exchange.trouble is not None:
            self._show_message(exchange.trouble.translated(), Meaning.ATTENTION)
        elif seen is not None:
            altered = seen.done is not None and not seen.done.is_whole
            self._show_message(_state_text(seen.status.not_shared, seen.status.last_at, exchange.server, seen.done),
                      Meaning.ATTENTION if altered else None)  # fmt: skip
        if self.isVisible():
            self._load()

    def _refresh_buttons(self) -> None:
        may_decide = not self._exchange.is_running and bool(self.who.text().strip())
        for button in (self.same, self.same_other, self.different):
            button.setEnabled(may_decide)

    def _show_message(self, text: str, meaning: Meaning | None) -> None:
        self.state.setText(text)
        self.sign.show_icon(Icon.BUNDLE if meaning is None else Icon.WARNING, meaning, is_muted=meaning is None)

    def _load(self) -> None:
        storage = self._services.storage

        def load() -> Loaded:
            with opened_archive(storage) as archive:
                names = names_of(archive)
                states = fleet_state(archive, names, datetime.now(UTC))
                return Loaded(tuple(states), names.conflicts)

        self._loading.run(lambda _running: load(), self._show, self._fail)

    def _show(self, loaded: Loaded) -> None:
        self.modules.show_rows(loaded.states)
        self._views.setCurrentIndex(0 if loaded.states else 1)
        self._conflicts = loaded.conflicts
        self._show_question()
        if loaded.states and not self.modules.selectionModel().hasSelection():
            select_row(self.modules, 0)
        self._show_life()

    def _show_question(self) -> None:
        self.question.setVisible(bool(self._conflicts))
        if not self._conflicts:
            return
        conflict = self._conflicts[0]
        first, second = conflict.pair
        names = [short_station(module.station) for module in conflict.pair]
        stations = tr("Stations: {one}, {other}.", one=names[0], other=names[1])
        question = join_sentences((conflict.question().translated(), stations))
        if question != self.asked.text():  # another one came under the hand
            for step in (self.same, self.same_other, self.different):
                step.appear()
        self.asked.setText(question)
        has_two_names = first.name != second.name
        self.same_other.setVisible(has_two_names)
        for button, module in ((self.same, first), (self.same_other, second)):
            name = clean(module.name, longest=30)
            text = tr("Same: “{name}”", name=name) if has_two_names else tr("Same module")
            button.setText(without_key(text))
            button.setAccessibleName(text)

    def _show_life(self) -> None:
        chosen = self.modules.chosen()
        self.service.setEnabled(bool(chosen) and not self._exchange.is_running)
        if not chosen:
            self.life.show_rows(())
            return
        module, storage = chosen[0].module, self._services.storage

        def load() -> tuple[HistoryEvent, ...]:
            with opened_archive(storage) as archive:
                return tuple(reversed(module_history(archive, module).events))

        self._loading_history.run(lambda _running: load(), self.life.show_rows, self._fail)

    def _fail(self, error: Exception) -> None:
        if not isinstance(error, UserError):
            raise error
        self._show_message(error.sentence, Meaning.ATTENTION)

    def _retranslate(self) -> None:
        self._show_question()
        self._refresh()


def _state_text(not_shared: int, last_at: str | None, server: str | None, done: Exchanged | None) -> str:
    parts = []
    if server is not None:
        parts.append(tr("Not shared: {count}. Last: {time}.", count=not_shared, time=last_time(last_at)))
    if done is not None:
        parts.append(tr("Sent: {sent}. Received: {received}.", sent=done.sent, received=done.received))
        if done.refused_count:
            text = tr("Left out, unreadable or altered: {count}.", count=done.refused_count)
            parts += [text, *(fact.sentence().translated() for fact in done.refused[:3])]
        if done.damaged:
            parts.append(tr("Damaged and not sent: {count}.", count=len(done.damaged)))
    return join_sentences(parts) or tr("No server is set.")


def _ask_save(parent: QWidget, then: ThenPath) -> None:
    """An existing file is extended."""
    ask_path(parent, tr("Export…"), Path.home() / f"dps-s{SUFFIX}", "*.dpsarchive", then, is_extended=True)


def _ask_open(parent: QWidget, then: ThenPath) -> None:
    ask_open(parent, Path.home(), tr("Import…"), "*.dpsarchive", then)
