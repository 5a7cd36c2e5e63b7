"""Connection, traffic, statistics and support bundle in tabs. While hidden the page only collects frames."""

import copy
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtWidgets import QFormLayout, QFrame, QLabel, QPlainTextEdit, QPushButton, QWidget

from app import version
from app.diagnosis.support_bundle import bundle_files, write_bundle
from app.engine.worker import Batch
from app.text import i18n
from app.text.i18n import tr
from app.text.messages import error_text, in_brackets, labelled
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.files.file_dialogs import AskPath, ask_path, default_name
from ui.pages.diagnosis.traffic import TrafficModel, TrafficView
from ui.pages.diagnosis.why import WhyPanel, figure
from ui.services.context import Services
from ui.services.page import Page
from ui.session.page_job import PageJob
from ui.session.shown_module import ShownModule
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space, fixed_font, is_text_large
from ui.widgets.controls import control, in_column, in_row, named, scroll_area, set_look, tabbed, text_label
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

_FIGURES: Final = {
    "sent": marked("Requests"),
    "lost": marked("Without reply"),
    "trip": marked("Round trip"),
    "late": marked("95th percentile"),
    "slowest": marked("Slowest answer"),
    "lag": marked("Lag"),
    "restarts": marked("Restarts"),
    "rejected": marked("Invalid bytes"),
}


class StatisticsView(QWidget):
    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("link_figures_view")
        self._ports = services.ports
        self.figures: dict[str, QLabel] = {}
        card = named(QFrame(), "figures_card", "card")
        form = QFormLayout(card)
        form.setHorizontalSpacing(Space.XL)
        for key, name in _FIGURES.items():
            self.figures[key] = figure(f"figures_{key}", tr(name))
            form.addRow(named(QLabel(tr(name)), f"figures_{key}_name", "muted"), self.figures[key])
        in_column(card, 1, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        VisibilityTimer(self, self.refresh, every_ms=500)

    def refresh(self) -> None:
        statistics, lag_s = self._ports.module.statistics, self._ports.module.view.lag_s
        totals = statistics.totals
        share = min(1.0, totals.time_outs / totals.sent) if totals.sent else 0.0
        whys = (labelled(tr(why.value), f"{count:,}") for why, count in totals.rejected_bytes.most_common() if count)
        texts = {
            "sent": f"{totals.sent:,}",
            "lost": f"{totals.time_outs:,}{in_brackets(f'{share * 100:.3g} %')}" if totals.sent else "—",
            "lag": "—" if lag_s is None else f"{lag_s:.2f} s",
            "restarts": f"{totals.restarts:,}",
            "rejected": "\n".join((f"{totals.rejected:,}", *whys)),
        }
        for key, quantile in (("trip", 0.5), ("late", 0.95), ("slowest", 1.0)):
            trip_s = statistics.quantile_s(quantile)
            texts[key] = "—" if trip_s is None else f"{trip_s * 1000:.1f} ms"
        warned = {"lost": share > 0.01, "rejected": totals.rejected > 0}
        for key, text in texts.items():
            self.figures[key].setText(text)
            set_look("attention" if warned.get(key) else "", self.figures[key])


class BundlePreview(QWidget):
    """The support bundle, made each time it is shown, and seen before it is saved."""

    def __init__(self, services: Services, traffic: TrafficModel, result: PageJob) -> None:
        super().__init__()
        self.setObjectName("bundle_preview")
        self.ask_path: AskPath = ask_path
        self._services, self._traffic, self._result = services, traffic, result
        self.log = services.log
        # Texts by the name of the file.
        self.files: dict[str, str] | None = None
        self._making: BackgroundTask[dict[str, str]] = BackgroundTask("dps-s support bundle", self)
        promised = tr(
            "The names of the user and the computer are replaced. Names of modules, files and ports, serial "
            "numbers and addresses stay: read everything before you pass it on. Nothing is sent."
        )
        promise = text_label("bundle_promise", text=promised)
        self.text = named(QPlainTextEdit(), "bundle_text", says=tr("Contents"))
        self.text.setReadOnly(True)
        self.text.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self.text.setTabChangesFocus(True)
        self.text.setFont(fixed_font(Size.SMALL))
        save = QPushButton(tr("Save support bundle…"))
        self.save = control(save, "bundle_save", picture=Icon.BUNDLE, role="primary", slot=self.choose_and_save)
        parts = (promise, in_row(1, self.save), (self.text, 1))
        in_column(*parts, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        self._timer = VisibilityTimer(self, self.make)

    def begin_again(self) -> None:
        """What is shown, or still being made, is of the former module."""
        self._making.cancel()
        self.files = None
        self.text.clear()
        self._timer.refresh_seen()

    def make(self) -> None:
        """Makes the bundle in the background from the present state, of which a copy is taken now."""
        services, log = self._services, self.log
        make = partial(
            bundle_files,
            version=version(),
            connection=services.ports.current.connection,
            conversation=services.ports.module.view,
            statistics=copy.copy(services.ports.module.statistics),
            preferences={"language": i18n.language(), "theme": services.appearance.choice.value},
            traffic=(*self._traffic.rows, *self._traffic.new),
        )

        def fail(error: Exception) -> None:
            self._result.notify(Meaning.ATTENTION, tr("Failed: {why}.", why=error_text(error)))

        self.save.setEnabled(False)
        self._making.run(lambda _running: make(log="" if log is None else log.text()), self._show, fail)

    def choose_and_save(self) -> None:
        """Saves the bundle that is shown."""
        files = self.files
        if files is None or self._result.is_busy:
            return

        def save(path: Path) -> None:
            self._result.write_file(path, partial(write_bundle, path, files))

        name = default_name("support", ".zip", datetime.now().astimezone())
        self.ask_path(self, tr("Save support bundle…"), Path(name), "*.zip", save)

    def _show(self, files: dict[str, str]) -> None:
        self.files = files
        self.save.setEnabled(True)
        self.text.setPlainText("\n".join(f"——— {name} ———\n{text}" for name, text in files.items()))


class DiagnosisPage(Page):
    shows_link = True

    def __init__(self, services: Services) -> None:
        super().__init__("diagnosis")
        self._opening = 0
        self.traffic = TrafficView()
        self.why = WhyPanel(services, self)
        self.statistics = StatisticsView(services)
        self.result = PageJob(self)
        self.bundle = BundlePreview(services, self.traffic.model, self.result)
        self.strip = named(NoticeBar(), "diagnosis_notice")
        tabs = self.tabs = tabbed("diagnosis", tr("Diagnosis"))
        self._keys: list[str] = []
        for key, title, view, scrolls in (
            ("why", tr("Connection"), self.why, True),
            ("traffic", tr("Traffic"), self.traffic, False),
            ("figures", tr("Statistics"), self.statistics, True),
            ("bundle", tr("Support"), self.bundle, False),
        ):
            # In large text the page scrolls as a whole.
            is_area = scrolls and not is_text_large()
            shown = scroll_area(view, f"{key}_scroll", title, is_vertical=True) if is_area else view
            shown.setAccessibleName(title)
            self._keys.append(key)
            tabs.addTab(shown, title)
        head = in_column(self.make_header(tr("Diagnosis")), margins=(Space.M, 0))
        # The notice is below all controls, so that it moves none of them.
        in_column(head, (tabs, 1), self.strip, of=self, spacing=Space.XS, margins=0)
        self.result.changed.connect(lambda: self.strip.show_notices(self.result.notices))
        services.ports.chosen.connect(self._begin_again)

    def show_module(self, module: ShownModule) -> None:
        super().show_module(module)
        self.bundle.begin_again()

    def on_batch(self, batch: Batch) -> None:
        if batch.connection.opening != self._opening:
            self._opening = batch.connection.opening
            self._begin_again()
        self.traffic.model.append(batch.events)

    def go_to(self, key: str) -> None:
        """Shows a view: "why", "traffic", "figures" or "bundle"."""
        self.tabs.setCurrentIndex(self._keys.index(key))

    def _begin_again(self) -> None:
        """Frames of two connections are never in one list, nor in one bundle."""
        self.traffic.begin_again()
        self.bundle.begin_again()
