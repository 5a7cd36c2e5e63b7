"""Logs page: recordings and flight logs, and which thresholds would have fired in them. It never sends anything.

`LogsWork` has the logs and reads them. The list stands beside `ThresholdPanel` and `FireMapView`, above a
`ProposalBar`; `LogView` shows one log in their place.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Final, cast

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QBoxLayout,
    QLabel,
    QPushButton,
    QStackedWidget,
    QToolBar,
    QToolButton,
    QWhatsThis,
    QWidget,
)

from app.flights.judge import ASSUMPTIONS, RULES
from app.flights.judging import FlightGroup, fire_map
from app.flights.read_log import SUFFIXES
from app.flights.table import CsvColumns
from app.recordings.library import RecordingEntry, entry_text, size_text, when_text
from app.recordings.recording import export
from app.text.i18n import tr
from app.text.messages import (
    UserError,
    UserMessage,
    capitalised,
    clean,
    error_text,
    in_brackets,
    join_names,
    join_sentences,
    labelled,
    not_written,
    saved_text,
)
from protocol.translatable import marked
from ui.core.background_task import Running
from ui.files.file_dialogs import AskMany, AskPath, ask_flight_logs, ask_folder, ask_path, default_name
from ui.forms.tables import RowsTable, SearchedRows
from ui.pages.logs.rows import COLUMNS, SIDES, LogColumn, LogRow, LogsWork, limits_text, row_text, sides_text
from ui.pages.logs.thresholds import FireMapView, ProposalBar, ThresholdPanel, bounds_lines
from ui.pages.logs.viewer import LogView
from ui.services.context import Services
from ui.services.page import Page, WaysBack
from ui.session.page_job import PageJob
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, RowHeight, Space, is_text_large, scaled
from ui.widgets.controls import control, in_column, in_row, named, set_role, stacked
from ui.widgets.notices import Choice, Notice
from ui.widgets.visibility_timer import VisibilityTimer

# The recordings, while the page is visible.
_LIST_MS: Final = 2000
_MAP_PX: Final = 280
_LEAST_LIST_PX: Final = 160
# Of files that cannot be read; the reason of each is in its row, too.
_REASONS_SHOWN: Final = 20


class LogsPage(Page):
    suffixes = SUFFIXES

    def __init__(self, services: Services) -> None:
        super().__init__("logs")
        self.result = PageJob(self, is_of_module=False)
        self.work = LogsWork(services.storage.library, self.result)
        self.ask_files: AskMany = ask_flight_logs
        self.ask_folder: AskMany = ask_folder
        self.ask_path: AskPath = ask_path
        self._folder = Path.home()
        self.table: RowsTable[LogRow] = RowsTable(
            "logs_table",
            tr("Logs"),
            COLUMNS,
            lambda row: row.name,
            row_text,
            row_px=RowHeight.LIST,
            sorted_by=LogColumn.WHEN,
        )
        self.table.setAlternatingRowColors(True)
        self.table.setMinimumHeight(scaled(_LEAST_LIST_PX))
        self.table.setTextElideMode(Qt.TextElideMode.ElideMiddle)  # file names mostly differ at the end
        self.table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        words = tr("No logs yet"), tr("Every session is recorded. Open or drop logs of PX4, ArduPilot, or CSV.")
        self.list = SearchedRows("logs", self.table, Icon.MAP, *words)
        self.counts = named(QLabel(), "logs_counts", "small")
        self.thresholds = ThresholdPanel()
        self.map = FireMapView()
        self.proposal = ProposalBar(services.exchange, self.work, self.thresholds)
        self.strip = self.proposal.strip
        self.view = LogView(services.in_use)
        self._make_actions()
        self._lay_out()
        work = self.work
        work.changed.connect(self.refresh_list)
        work.ended.connect(self._end_loading)
        self.thresholds.chosen.connect(work.choose)
        self.thresholds.judged.connect(self.proposal.refresh)
        self.map.chosen.connect(
            lambda tilt, time_s: work.choose(work.limits._replace(attitude_threshold_deg=tilt, freefall_time_s=time_s))
        )
        self.table.opened.connect(self._open_chosen)
        self.table.selectionModel().selectionChanged.connect(self._refresh_actions)
        self.view.closed.connect(self._show_list)
        self.view.columns_chosen.connect(self._read_with)
        self.result.changed.connect(self._refresh_notice)
        self.proposal.use.clicked.connect(lambda: self.page_wanted.emit("settings"))
        VisibilityTimer(self, self._list_again, every_ms=_LIST_MS)
        self.refresh_list()

    def _make_actions(self) -> None:
        """Make the actions for the chosen logs, in a bar above the list and in its menu."""

        def move(group: FlightGroup) -> None:
            self.work.move([row.name for row in self.table.chosen()], group)

        self.bar = named(QToolBar(), "logs_actions")
        self.bar.setIconSize(self.table.iconSize())
        sides = (
            (f"to_{group.name.lower()}", capitalised(tr(group.value)), tr(tip), picture, key, partial(move, group))
            for group, (tip, key, picture) in SIDES.items()
        )
        actions: tuple[tuple[str, str, str, Icon, str, Callable[[], None]], ...] = (
            ("open", tr("Open"), "", Icon.LIVE, "Return", self._open_chosen),
            *sides,
            ("export", tr("Export…"), "", Icon.SAVE, "Ctrl+E", self._export),
            ("remove", tr("Remove"), "", Icon.ERASE, "Del", self._remove),
        )
        self.action: dict[str, QAction] = {}
        for name, text, tip, picture, key, slot in actions:
            action = self.action[name] = named(QAction(icon(picture), text, self), f"logs_{name}")
            action.setShortcut(key)
            action.setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
            action.setAutoRepeat(False)
            action.setToolTip((tip or text) + in_brackets(key))
            action.triggered.connect(slot)
            self.table.addAction(action)
            self.bar.addAction(action)
            shown = cast("QToolButton", named(self.bar.widgetForAction(action), f"logs_{name}_chosen"))
            shown.setFocusPolicy(Qt.FocusPolicy.TabFocus)  # in a bar Qt gives it none
            if tip:
                shown.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)

    def _lay_out(self) -> None:
        opening = control(QPushButton(tr("Open…")), "logs_open", keys="Ctrl+O", picture=Icon.FOLDER, role="primary")
        opening.clicked.connect(self.choose_files)
        header = self.make_header(tr("Logs"), self.list.search, opening)
        folder = header.add_rare("logs_open_folder", tr("Open folder…"), self.choose_folder)
        folder.setShortcut("Ctrl+Shift+O")
        self.addAction(folder)
        header.add_rare("logs_about", tr("How this is judged"), self._explain)
        self.map.setMinimumWidth(_MAP_PX)
        both = in_row(
            (in_column(self.bar, self.counts, (self.list, 1)), 7), (in_column(self.thresholds, (self.map, 1)), 3)
        )
        if is_text_large():
            both.setDirection(QBoxLayout.Direction.TopToBottom)
        self._overview = QWidget()
        in_column(header, (both, 1), self.proposal, of=self._overview, margins=0)
        self._stack = stacked(named(QStackedWidget(), "logs_stack"), self._overview, self.view)
        in_column(self._stack, of=self, margins=(Space.M, 0, Space.M, Space.S))

    # Opening

    def choose_files(self) -> None:
        self.ask_files(self, self._folder, self.open_files)

    def choose_folder(self) -> None:
        self.ask_folder(self, self._folder, self.open_files)

    def open_file(self, path: Path) -> None:
        self.open_files([path])

    def open_files(self, paths: Sequence[Path], columns: CsvColumns | None = None) -> None:
        """Reads all of them, and says of each that cannot be read why; a single one is shown."""
        if paths:
            self._folder = paths[0].parent
            self.result.dismiss()
            self._show_list()
            self.table.clearSelection()
            self.work.open(paths, columns, partial(self._show_opened, len(paths)))
            self.refresh_list()

    def open_row(self, row: LogRow) -> None:
        """Shows a log, or why it could not be read."""
        if row.entry is not None and row.entry.trouble is None and row.log.is_waiting:
            self.work.open([row.entry.path])
        self.view.show_log(row, self.work.limits)
        self._stack.setCurrentWidget(self.view)
        self.view.back.setFocus()

    def _open_chosen(self) -> None:
        rows = self.table.chosen()
        if len(rows) == 1:
            self.open_row(rows[0])

    def _show_list(self) -> None:
        self.view.clear()
        self._stack.setCurrentWidget(self._overview)

    def _read_with(self, name: str, columns: CsvColumns) -> None:
        """Reads every table that has the same columns."""
        unread = self.work.unread()
        heads = {log.name: log.head for log in unread}
        self.open_files([Path(log.name) for log in unread if log.head == heads.get(name)], columns)

    def _end_loading(self, names: list[str]) -> None:
        self.result.set_notice(partial(self._read_notice, names), "logs")
        self.refresh_list()

    def _show_opened(self, count: int, names: list[str]) -> None:
        # What a person has chosen meanwhile stays chosen: the next key is for that.
        if not self.table.chosen():
            self.table.choose(lambda row: row.name in names)
            chosen = self.table.chosen()
            if chosen:
                self.table.scrollTo(self.table.selectionModel().selectedRows()[0])
            if count == 1 == len(chosen):
                self.open_row(chosen[0])

    def _read_notice(self, names: list[str]) -> Notice | None:
        """Return a notice on each log that could not be read, as long as it is there; None where everything was
        read."""
        if not names:
            return Notice(Meaning.INFORMATION, tr("No logs found."))
        unread = [log for log in self.work.unread() if log.name in names]
        lines = [tr("{count} of {total} not read.", count=len(unread), total=len(names))]
        for log in unread[:_REASONS_SHOWN]:
            if log.why_not is not None:
                why = clean(log.why_not.translated(), longest=400)
                lines.append(labelled(clean(Path(log.name).name, longest=80), why))
        return Notice(Meaning.ATTENTION, "\n".join(lines)) if unread else None

    # Showing

    def refresh(self) -> None:
        """Settings take no thresholds while no module is there, or while it is written to."""
        self.proposal.refresh_use()

    def refresh_list(self) -> None:
        work, rows = self.work, self.work.rows()
        self.list.show_rows(rows)
        text, is_bad = sides_text(rows)
        self.counts.setText(text)
        set_role(self.counts, "danger" if is_bad else "small")
        must = work.side(FlightGroup.MUST)
        self.map.show_map(*fire_map(work.side(FlightGroup.MUST_NOT), must, work.limits), has_must=bool(must))
        self.map.show_limits(work.limits, labelled(limits_text(work.limits), text))
        self.thresholds.show_limits(work.limits)
        self.proposal.refresh()
        self._refresh_notice()
        self._refresh_actions()

    def _refresh_notice(self) -> None:
        self.proposal.show_notices(self.result.notices)

    def _explain(self) -> None:
        rules = (*RULES, *ASSUMPTIONS, marked("After a real trigger the parachute is open."))
        text = "".join(f"<p>{sentence}</p>" for sentence in (*map(tr, rules), *bounds_lines()))
        QWhatsThis.showText(self.mapToGlobal(self.rect().center()), text, self)

    def _list_again(self) -> None:
        if not self.work.listing.is_running:
            self.work.list_again()

    # What is done with the chosen ones

    def _entries(self) -> tuple[RecordingEntry, ...]:
        return tuple(row.entry for row in self.table.chosen() if row.entry is not None)

    def _refresh_actions(self) -> None:
        rows, entries = self.table.chosen(), self._entries()
        is_recording = len(entries) == 1 == len(rows) and entries[0].trouble is None
        for action in self.action.values():
            action.setEnabled(bool(rows))
        self.action["open"].setEnabled(len(rows) == 1)
        self.action["export"].setEnabled(is_recording)
        removing = self.action["remove"]
        removing.setEnabled(bool(rows) and not any(entry.is_running for entry in entries))
        removing.setText(tr("Delete…") if entries else tr("Remove"))

    def _export(self) -> None:
        (entry,) = self._entries()
        name = default_name(entry.module or entry.port, ".csv", entry.started_at.astimezone())

        def save(path: Path) -> None:
            def work(running: Running) -> tuple[int, UserMessage | None]:
                return export(entry, path, on_progress=running.set_progress_or_end)

            def end(done: tuple[int, UserMessage | None]) -> None:
                rows, damage = done
                text = join_sentences([saved_text(path, rows), "" if damage is None else damage.translated()])
                self.result.notify_saved(path, text, Meaning.GOOD if damage is None else Meaning.ATTENTION)

            doing = tr("Exporting {name}", name=path.name)
            self.result.begin(doing, work, end, partial(not_written, path), cause=str(path))

        title = tr("Recording of {time}", time=when_text(entry))
        self.ask_path(self, title, Path(name), "*.csv;;*.mcap", save)

    def _remove(self) -> None:
        """Logs leave the list, and recordings are deleted, once that is confirmed."""
        self.work.remove([row.name for row in self.table.chosen() if row.entry is None])
        if not (entries := self._entries()):
            return
        what = entry_text(entries[0])
        if len(entries) > 1:
            size = size_text(sum(entry.size_bytes for entry in entries))
            what = join_names((labelled(tr("Recordings"), len(entries)), size))
        choices = (
            Choice("delete_recordings", tr("Delete for good"), partial(self._delete, entries), is_step=True),
            Choice("keep_recordings", tr("Cancel"), self.result.dismiss, is_main=True),
        )
        self.result.set_notice(Notice(Meaning.ATTENTION, tr("Delete for good? {what}", what=what), choices))
        if (safe := self.strip.button("keep_recordings")) is not None:
            safe.setFocus()

    def _delete(self, entries: tuple[RecordingEntry, ...]) -> None:
        deleted: list[str] = []

        def work(running: Running) -> None:
            for entry in entries:
                if running.is_cancelled():
                    return
                self.work.library.delete(entry)
                deleted.append(str(entry.path))
                running.share = len(deleted) / len(entries)

        def forget() -> None:
            """What could not be deleted keeps its side."""
            self.work.remove(deleted)
            self.work.list_again()

        def end(_none: None) -> None:
            self.result.notify(Meaning.INFORMATION, tr("Recordings deleted: {count}.", count=len(deleted)))
            forget()

        def refused(error: Exception) -> str:
            forget()
            return error.sentence if isinstance(error, UserError) else tr("Failed: {why}.", why=error_text(error))

        self.result.begin(tr("Deleting…"), work, end, refused)
        self.table.setFocus()

    # Qt

    def ways_back(self) -> WaysBack:
        return (
            (self._stack.currentWidget() is self.view, self.view.close_log),
            (self.result.is_busy, self.result.cancel_files),
            (self.result.said, self.result.dismiss),
        )
