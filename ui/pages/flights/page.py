"""Flight logs page: which thresholds would have fired in which flights. It never sends anything to a module."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QMimeData, Qt
from PySide6.QtGui import QDragEnterEvent, QDropEvent, QShowEvent
from PySide6.QtWidgets import QBoxLayout, QPushButton, QSizePolicy, QStackedWidget, QWhatsThis, QWidget

from app.flights.columns import CsvColumns
from app.flights.judge import ASSUMPTIONS, RULES, TriggerLimits
from app.flights.read_log import SUFFIXES
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import join_sentences, labelled
from protocol.fields import Value
from protocol.translatable import marked
from ui.files.file_dialogs import AskMany, ask_flight_logs, ask_folder
from ui.pages.flights.controller import Flight, FlightRow, FlightsWork, LoadEnded, Settle
from ui.pages.flights.lists import FlightLists, assumed_text, limits_text
from ui.pages.flights.proposal_bar import ProposalBar, bounds_lines
from ui.pages.flights.thresholds import FireMapView, ThresholdPanel
from ui.pages.flights.views import ColumnLine, FlightView
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.services.page import Page, WaysBack
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space, is_text_large
from ui.widgets.controls import control, named
from ui.widgets.labels import EmptyState
from ui.widgets.layouts import in_column, in_row, scroll_area, stacked
from ui.widgets.notice_bar import Choice, Notice
from ui.widgets.visibility_timer import VisibilityTimer

_POLL_MS: Final = 200
"""For progress of reading, while the page is visible."""
_MAP_PX: Final = 300
_REASONS_SHOWN: Final = 4
"""Of files that cannot be read; the reason of each is in its row, too."""


class FlightsPage(Page):
    """`FlightLists` beside `ThresholdPanel` and `FireMapView`, or one `FlightView`, or a `ColumnLine` for a table;
    a `ProposalBar` below. `FlightsWork` has the flights and reads them.
    """

    suffixes = SUFFIXES

    def __init__(self, services: Services) -> None:
        super().__init__("flights")
        self._services = services
        self.work = FlightsWork(self)
        self.ask_files: AskMany = ask_flight_logs
        self.ask_folder: AskMany = ask_folder
        self._folder = Path.home()
        self.result = JobNotice(self, is_of_module=False)
        self.open_files = control(
            QPushButton(tr("Open…")),
            "flights_open",
            keys="Ctrl+O",
            picture=Icon.FOLDER,
            role="primary",
            slot=self.choose_files,
        )
        self.thresholds = ThresholdPanel()
        self.map = FireMapView()
        self.lists = FlightLists()
        self.proposal = ProposalBar(services, self.work, self.result)
        self.strip = self.proposal.strip
        self.flight = FlightView()
        self.form = ColumnLine()
        how = tr("Open or drop logs of PX4, ArduPilot, CSV or recordings.")
        self.empty = EmptyState("flights_empty", Icon.MAP, tr("No flight logs yet"), how)
        folder = control(
            QPushButton(tr("Open folder…")), "flights_empty_folder", picture=Icon.FOLDER, slot=self.choose_folder
        )
        self.empty.column.insertWidget(4, folder, 0, Qt.AlignmentFlag.AlignHCenter)
        self._are_kept_read = False
        self._tried = ""
        """The recording that thresholds are to be tried on, until it is read."""
        self._tried_with: tuple[TriggerLimits, Mapping[str, Value]] | None = None
        """The thresholds that were tried last, and the settings that they are of."""
        self._overview = self._make_overview()
        self._stack = stacked(
            named(QStackedWidget(), "flights_stack"), self.empty, self._overview, self.flight, self.form
        )
        self._lay_out()
        self._wire()
        self.setAcceptDrops(True)
        VisibilityTimer(self, self._tick, every_ms=_POLL_MS, restyle=self._fit)
        self._fit()
        self.refresh()

    def _fit(self) -> None:
        """Large text has the map below the lists, and the buttons below the proposal."""
        is_large, direction = is_text_large(), QBoxLayout.Direction
        for row in (self._both, self.proposal.row):
            row.setDirection(direction.TopToBottom if is_large else direction.LeftToRight)
        for part in self.lists.of.values():
            part.fit()

    def showEvent(self, event: QShowEvent) -> None:
        """The flights of the last start are read when the page is first seen."""
        super().showEvent(event)
        if not self._are_kept_read:
            self._are_kept_read = True
            self.work.restore(self._services.preferences.flight_lists)

    def _keep_lists(self) -> None:
        if self._are_kept_read:
            self._services.preferences.flight_lists = self.work.kept_lists

    def choose_files(self) -> None:
        self.ask_files(self, self._folder, self.open_paths)

    def choose_folder(self) -> None:
        self.ask_folder(self, self._folder, self.open_paths)

    def open_file(self, path: Path) -> None:
        self.open_paths([path])

    def open_paths(self, paths: Sequence[Path], columns: CsvColumns | None = None) -> None:
        if not paths:
            return
        self._folder = paths[0].parent
        self.result.dismiss()
        self.work.open(paths, columns)
        self.refresh()

    def _try(self, values: Mapping[str, Value], path: Path | None, settle: Settle) -> None:
        """These thresholds, on the flights that are there and on what was recorded."""
        self.work.choose(self.thresholds.nearest(values))
        self._tried_with = self.work.limits, values
        self.result.set_notice_of_now(self._assumed_notice)
        self._show_overview()
        if path is not None:
            self._tried = str(path)
            self.work.read_again(path, settle)
        self.refresh()

    def _forget_tried(self) -> None:
        """What was tried is of a former module: where nobody chose otherwise since, the thresholds are too."""
        tried, self._tried_with = self._tried_with, None
        if tried is not None and tried[0] == self.work.limits:
            self.work.choose(TriggerLimits())
        self._refresh_notice()

    def _explain(self) -> None:
        rules = (*RULES, *ASSUMPTIONS, marked("After a real trigger the parachute is open."))
        text = "".join(f"<p>{sentence}</p>" for sentence in (*map(tr, rules), *bounds_lines()))
        QWhatsThis.showText(self.mapToGlobal(self.rect().center()), text, self)

    def open_flight(self, row: FlightRow) -> None:
        """Shows the plots of a flight, or the line for the columns of an unread table."""
        if row.flight.head:
            self._show_form(row.flight)
        elif row.outcome is not None:
            self.flight.show_flight(row.outcome, self.work.limits, row.flight.columns)
            self._show(self.flight)
            self.flight.back.setFocus()

    def _show_form(self, unread: Flight) -> None:
        self.form.show_file(unread.name, unread.why_not, unread.columns)
        self._show(self.form)

    def _read_with(self, name: str, columns: CsvColumns) -> None:
        """Reads every file that has the same columns."""
        unread = self.work.unread()
        heads = {log.name: log.head for log in unread}
        self._show_overview()
        self.open_paths([Path(log.name) for log in unread if log.head == heads.get(name)], columns)

    # Showing

    def refresh(self) -> None:
        self._refresh_thresholds()
        self._refresh_notice()
        if self._stack.currentWidget() in (self.empty, self._overview):
            self._show_overview()

    def _refresh_thresholds(self) -> None:
        """Updates map and lists after a change of thresholds or reading."""
        work = self.work
        if not work.is_empty:
            self.map.show_maps(*work.maps())
        self.lists.show_rows(work.rows())
        counts = tuple(part.caption.text() for part in self.lists.of.values())
        self.map.show_limits(work.limits, labelled(limits_text(work.limits), " · ".join(counts)))  # fmt: skip
        self.thresholds.show_limits(work.limits, work.reading)
        self._refresh_proposal()

    def _refresh_proposal(self) -> None:
        self.proposal.refresh(is_mistyped=self.thresholds.is_wrong)

    def _refresh_notice(self) -> None:
        self.strip.show_notice(self._notice())

    def _notice(self) -> Notice | None:
        loading, task = self.work.loading, self.work.task
        if task.is_running:
            text = tr("Reading logs…")
            if loading.total is not None:
                text = tr("{what} ({done} of {total})", what=text, done=loading.read, total=loading.total)
            return Notice(Meaning.INFORMATION, text, (Choice("cancel_flights", tr("Cancel"), self.work.cancel),))
        if self._stack.currentWidget() is self.form:
            return None  # which it leads to
        return self.result.result_notice()

    def _ended_notice(self, ended: LoadEnded) -> Notice | None:
        """None where everything was read."""
        if ended.why:
            return Notice(Meaning.ATTENTION, tr("Failed: {why}.", why=ended.why))
        if ended.was_cancelled:
            read = [] if ended.total is None else [tr("{count} of {total} logs", count=ended.read, total=ended.total)]
            return Notice(Meaning.INFORMATION, join_sentences((tr("Cancelled."), *read)))
        unread = self.work.unread()
        if ended.total == 0:
            return Notice(Meaning.INFORMATION, tr("No new flight logs."))
        if not unread:
            return self._assumed_notice()
        reasons = [
            labelled(clean(Path(log.name).name, longest=80), clean(log.why_not.translated(), longest=400))
            for log in unread[:_REASONS_SHOWN]
            if log.why_not is not None
        ]
        total = len(self.work.flights)
        text = "\n".join([tr("{count} of {total} not read.", count=len(unread), total=total), *reasons])
        table = next((log for log in unread if log.head), None)
        choices = () if table is None else (
            Choice("columns", tr("Choose columns…"), partial(self._show_form, table)),
        )  # fmt: skip
        return Notice(Meaning.ATTENTION, text, choices, dismiss=self.result.dismiss)

    def _assumed_notice(self) -> Notice | None:
        """As long as these thresholds are the chosen ones."""
        limits, values = self._tried_with or (None, {})
        text = assumed_text(values) if limits == self.work.limits else ""
        return Notice(Meaning.ATTENTION, text, dismiss=self.result.dismiss) if text else None

    def _show_overview(self) -> None:
        self._show(self.empty if self.work.is_empty else self._overview)

    def _show(self, widget: QWidget) -> None:
        """Hides the page's header for the flight and the form, which have their own."""
        policy = QSizePolicy.Policy
        for view in (self.empty, self._overview, self.flight, self.form):
            # The views behind ask for no height: it would be taken from the proposal.
            vertical = policy.Expanding if view is widget else policy.Ignored
            view.setSizePolicy(view.sizePolicy().horizontalPolicy(), vertical)
        self._stack.setCurrentWidget(widget)
        self.header.setVisible(widget in (self.empty, self._overview))
        for part in (self.thresholds.reading, self.header.more):
            part.setVisible(widget is self._overview)
        self.proposal.show_proposal(is_wanted=widget is self._overview)
        self._refresh_notice()

    def _tick(self) -> None:
        self.work.poll()
        self._refresh_notice()
        self._refresh_proposal()

    def _end_loading(self, ended: LoadEnded) -> None:
        self.result.set_notice_of_now(partial(self._ended_notice, ended))
        self.refresh()
        for part in self.lists.of.values() if self._tried else ():
            part.table.choose(lambda row: row.name == self._tried)
        self._tried = ""

    # Making

    def _wire(self) -> None:
        work = self.work
        work.flights_changed.connect(self.refresh)
        work.flights_changed.connect(self._keep_lists)
        work.thresholds_changed.connect(self._refresh_thresholds)
        work.proposal_changed.connect(self._refresh_proposal)
        work.loading_ended.connect(self._end_loading)
        self.thresholds.chosen.connect(work.choose)
        self.thresholds.judged.connect(self._refresh_proposal)
        self.thresholds.reading_chosen.connect(work.choose_reading)
        self.map.chosen.connect(
            lambda tilt, time_s: work.choose(work.limits._replace(attitude_threshold_deg=tilt, freefall_time_s=time_s))
        )
        for part in self.lists.of.values():
            part.opened.connect(self.open_flight)
            part.move_wanted.connect(work.move)
            part.remove_wanted.connect(work.remove)
        self.flight.closed.connect(self._show_overview)
        self.form.closed.connect(self._show_overview)
        self.form.chosen.connect(self._read_with)
        self.result.changed.connect(self._refresh_notice)
        self._services.exchange.tried.connect(self._try)
        self._services.exchange.forgotten.connect(self._forget_tried)
        self.proposal.settings_wanted.connect(lambda: self.page_wanted.emit("settings"))

    def _make_overview(self) -> QWidget:
        content = named(QWidget(), "flights_content")
        right = in_column(self.thresholds, (self.map, 1), spacing=Space.S)
        self._both = in_row((self.lists, 5), (right, 3), of=content, spacing=Space.M, margins=0)
        self.map.setMinimumWidth(_MAP_PX)
        return scroll_area(content, "flights_scroll", tr("Flight logs"), is_vertical=True)

    def _lay_out(self) -> None:
        self.header = self.make_header(tr("Flight logs"), self.thresholds.reading, self.open_files)
        folder = self.header.add_rare("flights_open_folder", tr("Open folder…"), self.choose_folder)
        folder.setShortcut("Ctrl+Shift+O")
        folder.setAutoRepeat(False)
        self.addAction(folder)
        self.header.add_rare("flights_about", tr("How this is judged"), self._explain)
        self.header.add_rare("flights_profile_save", tr("Save as profile…"), self.proposal.save_profile)
        self.header.add_rare("flights_profile_put", tr("Add to a profile…"), self.proposal.add_to_profile)
        in_column(
            self.header, (self._stack, 1), self.proposal, of=self, spacing=Space.S,
            margins=(Space.M, 0, Space.M, Space.S),
        )  # fmt: skip

    # Qt

    def ways_back(self) -> WaysBack:
        shown = self._stack.currentWidget()
        return (
            (shown is self.flight, self.flight.close_flight),
            (shown is self.form, self._show_overview),
            (self.work.task.is_running, self.work.cancel),
            (self.result.result_notice(), self.result.dismiss),
        )

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if _dropped(event.mimeData()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        paths = _dropped(event.mimeData())
        if paths:
            event.acceptProposedAction()
            self.open_paths(paths)


def _dropped(data: QMimeData) -> list[Path]:
    """Dropped files and folders, whatever they are: each that cannot be read is named with its reason."""
    return [Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile()]
