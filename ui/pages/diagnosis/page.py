"""Diagnosis page: connection, traffic, statistics and support bundle in tabs.

While hidden it only collects frames, statistics and evidence.
"""

from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QTabBar, QTabWidget, QToolButton

from app.captures.text import MAX_FAULTS
from app.captures.traffic_buffer import TrafficBuffer
from app.engine.worker import Batch
from app.text.i18n import tr
from app.text.sentences import join_sentences, labelled
from protocol.translatable import marked
from ui.pages.diagnosis.bundle_preview import BundlePreview
from ui.pages.diagnosis.capture_files import OPENED_SUFFIXES, CaptureFiles, Opened
from ui.pages.diagnosis.link_statistics import LinkStatisticsView
from ui.pages.diagnosis.traffic import TrafficPage
from ui.pages.diagnosis.why_panel import WhyPanel
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.services.page import StreamPage
from ui.style.theme import Meaning, Space
from ui.widgets.controls import Shortcut, control, named
from ui.widgets.layouts import in_column
from ui.widgets.notice_bar import Choice, Notice, NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

_VIEWS: Final = (
    ("why", marked("Connection")),
    ("traffic", marked("Traffic")),
    ("figures", marked("Statistics")),
    ("bundle", marked("Support")),
)


class DiagnosisPage(StreamPage):
    suffixes = OPENED_SUFFIXES
    shows_link = True

    def __init__(self, services: Services) -> None:
        super().__init__("diagnosis")
        self._texts, self._connector = services.texts, services.connector
        self.traffic_buffer = TrafficBuffer()
        self.opened: Opened | None = None
        self.traffic = TrafficPage(services)
        self.why = WhyPanel(services)
        self.statistics = LinkStatisticsView(services)
        self.result = JobNotice(self)
        self.bundle = BundlePreview(services, self.traffic_buffer, self.result)
        self.files = CaptureFiles(services, self.traffic_buffer, self.result)
        self.strip = named(NoticeBar(services.texts), "diagnosis_notice")
        self.tabs = self._make_tabs()
        head = self.make_header(self._texts, marked("Diagnosis"), self.files)
        head.row.setContentsMargins(Space.M, 0, Space.M, 0)
        # The notice is below all controls, so that it moves none of them.
        in_column(head, (self.tabs, 1), self.strip, of=self, spacing=Space.XS, margins=0)
        self.files.opened.connect(self._show_capture)
        self.result.changed.connect(self._refresh_strip)
        self.why.connect_wanted.connect(self.connect_wanted)
        self.why.choose_wanted.connect(self.ports_wanted)
        self._connector.changed.connect(self._refresh_strip)
        self._connector.invalidated.connect(self._begin_again)
        Shortcut("capture_open_key", self, self.files.open, self.files.choose, keys=("Ctrl+O",))
        self.saving = Shortcut("capture_save_key", self, self.files.save, self.files.choose_and_save, keys=("Ctrl+S",))
        self.files.refresh()
        self.go_to("why")
        VisibilityTimer(self, self._refresh_strip)

    def on_batch(self, batch: Batch) -> None:
        if batch.events:
            self.traffic_buffer.feed(batch.events)
        self.traffic.on_batch(batch)
        self.why.on_batch(batch)
        if not self.files.save.isEnabled():
            self.files.refresh()

    def go_to(self, key: str) -> None:
        """Shows a view: "why", "traffic", "figures" or "bundle"."""
        keys = [view[0] for view in _VIEWS]
        self.tabs.setCurrentIndex(keys.index(key))

    def open_file(self, path: Path) -> None:
        self.go_to("traffic")
        self.files.open_file(path)

    # Captures

    def _begin_again(self) -> None:
        """Frames of two connections are never in one list, nor in one file."""
        self.traffic.model.clear()
        self.traffic.pause.setChecked(False)
        self.traffic_buffer.clear()
        self.files.refresh()
        self.bundle.begin_again()

    def _show_capture(self, opened: Opened) -> None:
        self.opened = opened
        self.traffic.show_recorded(opened.rows)
        self.statistics.show_recorded(opened.statistics)
        self.go_to("traffic")
        self._refresh_strip()

    def _close_capture(self) -> None:
        self.opened = None
        self.traffic.show_recorded(None)
        self.statistics.show_recorded(None)
        self._refresh_strip()

    def _capture_notice(self, opened: Opened) -> Notice:
        parts, faults = [labelled(opened.path.name, tr("rows: {rows}.", rows=f"{len(opened.rows):,}"))], opened.faults
        if not opened.is_timed:
            parts.append(tr("Times are estimated."))
        if faults:
            many = f"{len(faults)}+" if len(faults) == MAX_FAULTS else str(len(faults))
            parts.append(tr("Unreadable lines: {count}.", count=many))
            parts.append(tr("Line {line}: {what}", line=faults[0].line, what=tr(faults[0].text)))
        back = Choice("capture_leave", tr("Back to live"), self._close_capture)
        return Notice(Meaning.INFORMATION, join_sentences(parts), (back,))

    def _refresh_strip(self) -> None:
        notice = self.result.result_notice()
        if notice is None and self.opened is not None:
            notice = self._capture_notice(self.opened)
        self.strip.show_notice(notice)

    # Making

    def _make_tabs(self) -> QTabWidget:
        tabs, bar = named(QTabWidget(), "diagnosis_views"), QTabBar()
        tabs.setTabBar(control(bar, self._texts, "diagnosis_tabs", says="Diagnosis"))
        tabs.setDocumentMode(True)
        tabs.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        bar.setDrawBase(False)
        bar.setExpanding(False)
        tabs.setUsesScrollButtons(False)
        tabs.setElideMode(Qt.TextElideMode.ElideNone)
        # Qt makes the scroll buttons anyway, and names them in English only.
        for name, says in (("ScrollLeftButton", marked("Scroll left")), ("ScrollRightButton", marked("Scroll right"))):
            button = bar.findChild(QToolButton, name)
            if button is not None:
                control(button, self._texts, name, says=says, about=says)
        views = (self.why, self.traffic, self.statistics, self.bundle)
        for number, (view, (key, title)) in enumerate(zip(views, _VIEWS, strict=True)):
            shortcut = f"Alt+{number + 1}"
            tabs.addTab(view, "")
            self._texts.bind(view.setAccessibleName, title)
            self._texts.bind(partial(tabs.setTabText, number), title)
            tabs.setTabToolTip(number, shortcut)
            Shortcut(f"diagnosis_{key}_key", self, view, partial(self._choose, key), keys=(shortcut,))
        return tabs

    def _choose(self, key: str) -> None:
        self.go_to(key)
        self.tabs.tabBar().setFocus()
