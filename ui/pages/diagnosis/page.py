"""Diagnosis page: connection (`WhyPanel`), traffic, statistics and support bundle in tabs.

While hidden it only collects frames, statistics and evidence.
"""

import time
from functools import partial
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFrame, QPushButton, QTabBar, QTabWidget, QToolButton, QWidget

from app.diagnosis.adapter_facts import AdapterFacts, PortHistory, facts_about
from app.diagnosis.causes import STEP_WORDS, Cause, Diagnosis, NextStep, diagnose
from app.diagnosis.link_state import Phase, link_text
from app.diagnosis.symptoms import EvidenceCollector, PortEvidence
from app.engine.worker import Batch
from app.system.wall_clock import clock_text
from app.text.i18n import tr
from protocol.events import Role
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.pages.diagnosis.bundle import BundlePreview
from ui.pages.diagnosis.link_statistics import LinkStatisticsView, Tile
from ui.pages.diagnosis.traffic import TrafficPage
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.services.page import Page
from ui.session.shown_module import ShownModule
from ui.style.icons import MEANING_ICONS, Icon
from ui.style.theme import Meaning, Space, fixed_font
from ui.widgets.controls import Shortcut, control, named
from ui.widgets.labels import IconLabel, text_label
from ui.widgets.layouts import Gap, ScrollArea, in_column, in_row
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 500
FACTS_EVERY_S: Final = 5.0


_WITHOUT_CAUSE: Final = {
    Phase.ONLINE: (Meaning.GOOD, None),
    Phase.CLOSED: (Meaning.INFORMATION, NextStep.CHOOSE_PORT),
    Phase.OPENING: (Meaning.INFORMATION, None),
    Phase.FINDING: (Meaning.INFORMATION, None),
    Phase.ASKING: (Meaning.INFORMATION, None),
    Phase.LATE: (Meaning.ATTENTION, None),
}
_SEEN: Final = (
    ("port", marked("Port")),
    ("received", marked("Bytes")),
    ("frames", marked("Frames")),
    ("rejected", marked("Invalid bytes")),
    ("echo", marked("Echoed frames")),
    ("unanswered", marked("Without reply")),
    ("trip", marked("Round trip")),
    ("noise", marked("Last invalid bytes")),
)
_LONG: Final = ("port", "noise")
_NOISE_SHOWN: Final = 16


class WhyPanel(ScrollArea):
    """Collects evidence always, diagnoses while visible. `choose_wanted`: show the list of ports."""

    choose_wanted = Signal()
    connect_wanted = Signal(object)

    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("why_panel")
        self._ports, self._storage = services.ports, services.storage
        self._evidence, self._history = EvidenceCollector(), PortHistory()
        self._facts, self._facts_of, self._facts_at = AdapterFacts(), "", float("-inf")
        self._asking: BackgroundTask[AdapterFacts] = BackgroundTask("dps-s adapter facts", self)
        self.diagnosis: Diagnosis | None = None
        self._picture = IconLabel("why_icon", 28)
        self.what = text_label("why_what", "title", is_selectable=True)
        self.next_step = text_label("why_next_step", "", is_selectable=True)
        self.silence = text_label("why_silence", "muted", is_selectable=True)
        self.command = text_label("why_command", "", is_selectable=True)
        self.act = control(
            QPushButton(tr(STEP_WORDS[NextStep.CONNECT_AGAIN])),
            "why_act",
            picture=Icon.CHEVRON_RIGHT,
            role="primary",
            slot=self._do,
        )
        self._step: NextStep | None = None
        self.setAccessibleName(tr("Connection"))
        self.seen = {key: Tile(f"why_seen_{key}", tr(english), is_long=key in _LONG) for key, english in _SEEN}
        self._lay_out()
        self._ports.watcher.listed.connect(self._notice_ports)
        timer = VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS)
        self._ports.changed.connect(timer.refresh_seen)
        for label in (self.command, self.seen["noise"].figure):
            label.setFont(fixed_font())
        self.begin_again()
        self._notice_ports()

    def on_batch(self, batch: Batch) -> None:
        self._evidence.on_batch(batch)

    def evidence(self) -> PortEvidence:
        current, target = self._ports.current, self._ports.current.target
        port = "" if target is None else target.device
        # Of this adapter: another one may have the name of its port by now.
        facts = self._facts if self._facts_of == current.key else AdapterFacts()
        visits = self._history.short_visits(port, self._ports.clock())
        seen = self._evidence.evidence(facts=facts, short_visits=visits)
        # Of a module that was left active nobody can say that it is not this one.
        is_left = bool(self._storage.left_active) and not (target and target.is_simulated)
        seen = seen._replace(was_active=current.is_active or is_left)
        # Between two attempts to reconnect, only the connector knows the error.
        return seen if seen.is_open else seen._replace(trouble=current.state.trouble)

    def refresh(self) -> None:
        self._ask_system()
        evidence = self.evidence()
        state = self._ports.current.state
        is_asked = state.phase not in (Phase.CLOSED, Phase.OPENING, Phase.FINDING, Phase.LATE)
        self.diagnosis = diagnose(evidence) if is_asked else None
        if self.diagnosis is not None:
            meaning = Meaning.INFORMATION if self.diagnosis.cause is Cause.SLOW_ADAPTER else Meaning.ATTENTION
            self._show(meaning, self.diagnosis.what, self.diagnosis.next_step, self.diagnosis.command)
            is_idle = meaning is Meaning.INFORMATION and self.diagnosis.command is None
            self._offer(None if is_idle else self.diagnosis.step)
        else:
            self._show_without_cause(state.phase)
        self.silence.setText(self._silence_text(evidence))
        self.silence.setVisible(bool(self.silence.text()))
        self._show_seen(evidence)

    def _silence_text(self, evidence: PortEvidence) -> str:
        """What tells a silent module from a closed port; empty unless it has fallen silent."""
        current = self._ports.current
        if current.state.phase is not Phase.OFFLINE:
            return ""
        last = max(known.at for known in current.module.view.values.values())
        return tr(
            "Last value at {time}. Unanswered since: {lost} of {asked}. The port is open.",
            time=clock_text(time.time() - self._ports.clock() + last),
            lost=f"{evidence.counters.time_outs:,}", asked=f"{evidence.counters.sent:,}",
        )  # fmt: skip

    def _show_without_cause(self, phase: Phase) -> None:
        words = link_text(self._ports.current.state, self._ports.clock())
        meaning, step = _WITHOUT_CAUSE.get(phase, (Meaning.ATTENTION, NextStep.CONNECT_AGAIN))
        self._show(meaning, words.what, words.next_step, None)
        self._offer(step)

    # Evidence

    def begin_again(self) -> None:
        """Another port was opened."""
        target = self._ports.current.target
        if target is not None:
            self._evidence.begin(target.device)
        self._asking.cancel()
        self._facts_of = ""

    def _notice_ports(self) -> None:
        ports = self._ports.watcher
        if ports.is_current:  # an outdated list shows no changes
            self._history.poll(ports.ports, self._ports.clock())

    def _ask_system(self) -> None:
        """Queries the system in the background, since it lists all processes."""
        target, now = self._ports.current.target, time.monotonic()
        if target is None or self._asking.is_running:
            return
        if target.key == self._facts_of and now - self._facts_at < FACTS_EVERY_S:
            return
        port = target.device
        self._facts_at = now
        self._asking.run(lambda _running: facts_about(port), partial(self._on_facts, target.key), lambda _error: None)

    def _on_facts(self, key: str, facts: AdapterFacts) -> None:
        self._facts, self._facts_of = facts, key
        self.refresh()

    # Display

    def _show(self, meaning: Meaning, what: str, next_step: str, command: str | None) -> None:
        self.what.setText(what)
        self.next_step.setText(next_step)
        self.command.setText(command or "")
        self.next_step.setVisible(bool(next_step))
        self.command.setVisible(command is not None)
        self._picture.show_icon(MEANING_ICONS[meaning], meaning)

    def _offer(self, step: NextStep | None) -> None:
        self.act.setVisible(step is not None)
        if step is not None and step is not self._step:
            self.act.setText(tr(STEP_WORDS[step]))
        self._step = step
        self.act.setEnabled(step is not NextStep.FIND_RATE or self._ports.current.is_open)

    def _show_seen(self, evidence: PortEvidence) -> None:
        counters = evidence.counters
        trip_s = evidence.round_trip_median_s if counters.frames else None  # else it is of an earlier connection
        noise = evidence.noise[-_NOISE_SHOWN:]
        shown = {
            "port": tr("{port}, {rate} baud", port=evidence.port, rate=evidence.baud_rate) if evidence.port else "—",
            "received": f"{evidence.counters.bytes_received:,}",
            "frames": f"{counters.frames - counters.by_role[Role.ECHO]:,}",
            "rejected": f"{counters.rejected:,}",
            "echo": f"{counters.by_role[Role.ECHO]:,}",
            "unanswered": tr("{lost} of {asked}", lost=f"{counters.time_outs:,}", asked=f"{counters.sent:,}"),
            "trip": "—" if trip_s is None else f"{trip_s * 1000:.1f} ms",
            "noise": noise.hex(" ").upper() or "—",
        }
        self.seen["noise"].setVisible(bool(noise))
        for key, text in shown.items():
            self.seen[key].show_figure(text)

    def _do(self) -> None:
        match self._step:
            case NextStep.COPY_COMMAND if self.diagnosis is not None:
                QGuiApplication.clipboard().setText(self.diagnosis.command or "")
            case NextStep.CONNECT_AGAIN if self._ports.current.target is not None:
                self.connect_wanted.emit(self._ports.current.target)
            case NextStep.FIND_RATE:
                self._ports.current.find_rate()
            case _:
                self.choose_wanted.emit()

    # Making

    def _lay_out(self) -> None:
        card = named(QFrame(), "why_card", "card")
        button = in_row(self.act, 1)
        lines = in_column(self.what, self.next_step, self.silence, self.command, button, spacing=Space.S)
        in_row((self._picture, Qt.AlignmentFlag.AlignTop), (lines, 1), of=card, spacing=Space.L, margins=Space.L)
        tiles = self.seen
        rows = [
            in_row(*((tiles[key], 1) for key in ("trip", "unanswered", "rejected", "echo")), spacing=Space.L),
            in_row((tiles["received"], 1), (tiles["frames"], 1), (tiles["port"], 2), Gap(Space.L), spacing=Space.L),
        ]
        facts = named(QFrame(), "why_facts", "card")
        in_column(*rows, tiles["noise"], of=facts, spacing=Space.M, margins=(Space.L, Space.M))
        content = named(QWidget(), "why_content")
        in_column(card, facts, 1, of=content, spacing=Space.S, margins=(Space.M, Space.S))
        self.setWidget(content)


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
        self._ports = services.ports
        self.traffic = TrafficPage()
        self.why = WhyPanel(services)
        self.statistics = LinkStatisticsView(services)
        self.result = JobNotice(self)
        self.bundle = BundlePreview(services, self.traffic.model, self.result)
        self.strip = named(NoticeBar(), "diagnosis_notice")
        self.tabs = self._make_tabs()
        head = self.make_header(tr("Diagnosis"))
        head.row.setContentsMargins(Space.M, 0, Space.M, 0)
        # The notice is below all controls, so that it moves none of them.
        in_column(head, (self.tabs, 1), self.strip, of=self, spacing=Space.XS, margins=0)
        self.result.changed.connect(self._refresh_strip)
        self.why.connect_wanted.connect(self.connect_wanted)
        self.why.choose_wanted.connect(self.ports_wanted)
        self._ports.changed.connect(self._refresh_strip)
        self._ports.chosen.connect(self._begin_again)
        self._opening = 0
        self.go_to("why")
        VisibilityTimer(self, self._refresh_strip)

    def show_module(self, module: ShownModule) -> None:
        super().show_module(module)
        self.bundle.begin_again()

    def on_batch(self, batch: Batch) -> None:
        if batch.connection.opening != self._opening:
            self._opening = batch.connection.opening
            self._begin_again()
        self.traffic.on_batch(batch)
        self.why.on_batch(batch)

    def go_to(self, key: str) -> None:
        """Shows a view: "why", "traffic", "figures" or "bundle"."""
        keys = [view[0] for view in _VIEWS]
        self.tabs.setCurrentIndex(keys.index(key))

    def _begin_again(self) -> None:
        """Frames of two connections are never in one list, nor in one bundle."""
        self.traffic.model.clear()
        self.traffic.pause.setChecked(False)
        self.bundle.begin_again()
        self.why.begin_again()

    def _refresh_strip(self) -> None:
        self.strip.show_notice(self.result.result_notice())

    # Making

    def _make_tabs(self) -> QTabWidget:
        tabs, bar = named(QTabWidget(), "diagnosis_views"), QTabBar()
        tabs.setTabBar(control(bar, "diagnosis_tabs", says=tr("Diagnosis")))
        tabs.setDocumentMode(True)
        tabs.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # also of the bar, to which it passes the focus
        bar.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        bar.setDrawBase(False)
        bar.setExpanding(False)
        tabs.setUsesScrollButtons(False)
        tabs.setElideMode(Qt.TextElideMode.ElideNone)
        # Qt makes the scroll buttons anyway, and names them in English only.
        for name, says in (("ScrollLeftButton", marked("Scroll left")), ("ScrollRightButton", marked("Scroll right"))):
            button = bar.findChild(QToolButton, name)
            if button is not None:
                control(button, name, says=tr(says), about=tr(says))
        views = (self.why, self.traffic, self.statistics, self.bundle)
        for number, (view, (key, title)) in enumerate(zip(views, _VIEWS, strict=True)):
            shortcut = f"Alt+{number + 1}"
            tabs.addTab(view, "")
            view.setAccessibleName(tr(title))
            tabs.setTabText(number, tr(title))
            tabs.setTabToolTip(number, shortcut)
            Shortcut(view, shortcut, partial(self._choose, key), holder=self)
        return tabs

    def _choose(self, key: str) -> None:
        self.go_to(key)
        self.tabs.tabBar().setFocus()
