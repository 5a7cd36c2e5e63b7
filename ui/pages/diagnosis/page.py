"""Diagnosis page: connection, traffic, statistics and support bundle in tabs. While hidden it only collects frames."""

from functools import partial
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QTabWidget

from app.engine.worker import Batch
from app.text.i18n import tr
from protocol.translatable import marked
from ui.pages.diagnosis.panels import BundlePreview, StatisticsView
from ui.pages.diagnosis.traffic import TrafficView
from ui.pages.diagnosis.why import WhyPanel
from ui.services.context import Services
from ui.services.page import Page
from ui.session.page_job import PageJob
from ui.session.shown_module import ShownModule
from ui.style.theme import Space, is_text_large
from ui.widgets.controls import Shortcut, in_column, named, scroll_area
from ui.widgets.notice_bar import NoticeBar

_VIEWS: Final = (
    ("why", marked("Connection")),
    ("traffic", marked("Traffic")),
    ("figures", marked("Statistics")),
    ("bundle", marked("Support")),
)


class DiagnosisPage(Page):
    shows_link = True

    def __init__(self, services: Services) -> None:
        super().__init__("diagnosis")
        self._opening = 0
        self.traffic = TrafficView()
        self.why = WhyPanel(services)
        self.statistics = StatisticsView(services)
        self.result = PageJob(self)
        self.bundle = BundlePreview(services, self.traffic.model, self.result)
        self.strip = named(NoticeBar(), "diagnosis_notice")
        tabs = self.tabs = named(QTabWidget(), "diagnosis_views")
        tabs.setDocumentMode(True)
        tabs.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # also of the bar, to which it passes the focus
        tabs.setUsesScrollButtons(False)
        tabs.tabBar().setObjectName("diagnosis_tabs")
        tabs.tabBar().setAccessibleName(tr("Diagnosis"))
        tabs.tabBar().setFocusPolicy(Qt.FocusPolicy.TabFocus)
        views = [self.why, self.traffic, self.statistics, self.bundle]
        if not is_text_large():  # then the page scrolls as a whole
            views[0] = scroll_area(self.why, "why_scroll", tr("Connection"), is_vertical=True)
            views[2] = scroll_area(self.statistics, "figures_scroll", tr("Statistics"), is_vertical=True)
        for number, ((key, title), view) in enumerate(zip(_VIEWS, views, strict=True)):
            shortcut = f"Alt+{number + 1}"
            tabs.addTab(view, tr(title))
            view.setAccessibleName(tr(title))
            tabs.setTabToolTip(number, shortcut)
            Shortcut(view, shortcut, partial(self._choose, key), holder=self)
        head = self.make_header(tr("Diagnosis"))
        head.setContentsMargins(Space.M, 0, Space.M, 0)
        # The notice is below all controls, so that it moves none of them.
        in_column(head, (tabs, 1), self.strip, of=self, spacing=Space.XS, margins=0)
        self.result.changed.connect(lambda: self.strip.show_notice(self.result.result_notice()))
        self.why.connect_wanted.connect(self.connect_wanted)
        self.why.choose_wanted.connect(self.ports_wanted)
        services.ports.chosen.connect(self._begin_again)

    def show_module(self, module: ShownModule) -> None:
        super().show_module(module)
        self.bundle.begin_again()

    def on_batch(self, batch: Batch) -> None:
        if batch.connection.opening != self._opening:
            self._opening = batch.connection.opening
            self._begin_again()
        self.traffic.on_batch(batch)
        self.why.collector.on_batch(batch)

    def go_to(self, key: str) -> None:
        """Shows a view: "why", "traffic", "figures" or "bundle"."""
        self.tabs.setCurrentIndex([view[0] for view in _VIEWS].index(key))

    def _choose(self, key: str) -> None:
        self.go_to(key)
        self.tabs.tabBar().setFocus()

    def _begin_again(self) -> None:
        """Frames of two connections are never in one list, nor in one bundle."""
        self.traffic.begin_again()
        self.bundle.begin_again()
        self.why.begin_again()
