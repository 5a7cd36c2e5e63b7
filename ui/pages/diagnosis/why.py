"""Why does it not connect? The likely cause, the step that helps, and a list that ticks itself: how far it comes."""

from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QCheckBox, QFrame, QGridLayout, QLabel, QLineEdit, QPushButton, QWidget

from app.diagnosis.causes import Diagnosis, NextStep, PortEvidence, diagnose
from app.diagnosis.link_state import Phase
from app.text.i18n import tr
from app.text.messages import join_names, labelled
from protocol.events import Role
from protocol.translatable import marked
from ui.services.context import Services
from ui.services.page import Page
from ui.style.icons import MEANING_ICONS, Icon
from ui.style.theme import Meaning, Space, fixed_font
from ui.widgets.controls import (
    SELECTABLE,
    IconLabel,
    TickingLabel,
    control,
    in_column,
    in_row,
    named,
    set_role,
    text_label,
)
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 500
_WITHOUT_CAUSE: Final = {
    Phase.ONLINE: (Meaning.GOOD, None),
    Phase.CLOSED: (Meaning.INFORMATION, NextStep.CHOOSE_PORT),
    **dict.fromkeys((Phase.OPENING, Phase.FINDING, Phase.ASKING, Phase.SWITCHED_OFF), (Meaning.INFORMATION, None)),
    Phase.LATE: (Meaning.ATTENTION, None),
}
# The list that ticks itself.
_LINES: Final = {
    "port": marked("Port"),
    "bytes": marked("Bytes"),
    "frames": marked("Frames"),
    "replies": marked("Round trip"),
    "noise": marked("Last invalid bytes"),
}


def figure(name: str, says: str) -> TickingLabel:
    """A value that changes by itself; it can be selected."""
    label = named(TickingLabel(), name, "figure", says=says)
    label.setTextInteractionFlags(SELECTABLE)
    label.setWordWrap(True)
    return label


class WhyPanel(QWidget):
    """Diagnoses while visible."""

    def __init__(self, services: Services, page: Page) -> None:
        super().__init__()
        self.setObjectName("why_panel")
        self._ports, self._storage, self._page = services.ports, services.storage, page
        self.diagnosis: Diagnosis | None = None
        self._step: NextStep | None = None
        self._picture = IconLabel("why_icon", 28)
        self.what = text_label("why_what", "title", is_selectable=True)
        self.next_step = text_label("why_next_step", is_selectable=True)
        self.act = control(QPushButton(), "why_act", picture=Icon.CHEVRON_RIGHT, role="primary", slot=self._do)
        card = named(QFrame(), "why_card", "card")
        lines = in_column(self.what, self.next_step, in_row(self.act, 1), spacing=Space.S)
        in_row((self._picture, Qt.AlignmentFlag.AlignTop), (lines, 1), of=card, spacing=Space.L, margins=Space.L)
        checked = named(QFrame(), "why_list", "card")
        grid = QGridLayout(checked)
        grid.setHorizontalSpacing(Space.M)
        grid.setColumnStretch(2, 1)
        self.checked: dict[str, QLabel] = {}
        self._ticks: dict[str, IconLabel] = {}
        for row, (key, name) in enumerate(_LINES.items()):
            tick = self._ticks[key] = IconLabel(f"why_{key}_tick", 16, keeps_place=True)
            value = self.checked[key] = figure(f"why_{key}", tr(name))
            for column, cell in enumerate((tick, named(QLabel(tr(name)), f"why_{key}_name", "muted"), value)):
                grid.addWidget(cell, row, column)
        self.checked["noise"].setFont(fixed_font())
        self.sharing = SharingCard(services)
        in_column(card, checked, self.sharing, 1, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        timer = VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS)
        self._ports.changed.connect(timer.refresh_seen)

    # Evidence

    def evidence(self) -> PortEvidence:
        current, target = self._ports.current, self._ports.current.target
        # Of a module that was left active nobody can say that it is not this one.
        is_left = bool(self._storage.left_active) and not (target and target.is_simulated)
        seen = current.evidence._replace(
            was_active=current.is_active or is_left,
            adapter="" if target is None else target.identity,
        )
        # Between two attempts to reconnect, only the port knows the error.
        return seen if seen.is_open else seen._replace(trouble=current.trouble)

    # Display

    def refresh(self) -> None:
        evidence, state = self.evidence(), self._ports.current.state
        is_asked = state.phase not in (Phase.CLOSED, Phase.OPENING, Phase.FINDING, Phase.LATE, Phase.SWITCHED_OFF)
        self.diagnosis = found = diagnose(evidence) if is_asked else None
        if found is not None:
            meaning, self._step, said = Meaning.ATTENTION, found.step, (found.what, found.next_step)
        else:
            meaning, self._step = _WITHOUT_CAUSE.get(state.phase, (Meaning.ATTENTION, NextStep.CONNECT_AGAIN))
            said = state.what, state.next_step
        self._picture.show_icon(MEANING_ICONS[meaning], meaning)
        for label, text in zip((self.what, self.next_step), said, strict=True):
            label.setText(text)
            label.setVisible(bool(text))
        self.act.setVisible(self._step is not None)
        self.act.setEnabled(self._step is not NextStep.FIND_RATE or self._ports.current.is_open)
        if self._step is not None:
            self.act.setText(tr(self._step.value))
        self._tick(evidence)

    def _tick(self, evidence: PortEvidence) -> None:
        """Each line is met, not met, or not known yet: nothing was asked so far."""
        counters = evidence.counters
        echoes = counters.by_role[Role.ECHO]
        frames = counters.frames - echoes
        is_asked = evidence.is_open and counters.time_outs > 0
        for key, is_met, has_failed in (
            ("port", evidence.is_open, evidence.trouble is not None),
            ("bytes", counters.bytes_received > 0, is_asked),
            ("frames", frames > 0 and not evidence.is_bad_line(), is_asked),
            ("replies", evidence.is_answering, is_asked),
        ):
            if is_met:
                self._ticks[key].show_icon(Icon.CHECK, Meaning.GOOD)
            elif has_failed:
                self._ticks[key].show_icon(Icon.CROSS, Meaning.DANGER)
            else:
                self._ticks[key].show_icon(Icon.UNKNOWN, None)
        trip_s = self._ports.module.view.lag_s if counters.frames else None  # else it is of an earlier connection
        parts = [f"{frames:,}"]
        if counters.rejected:
            parts.append(labelled(tr("Invalid bytes"), f"{counters.rejected:,}"))
        if echoes:
            parts.append(labelled(tr("Echoed frames"), f"{echoes:,}"))
        lost = tr("{lost} of {asked}", lost=f"{counters.time_outs:,}", asked=f"{counters.sent:,}")
        trip = "—" if trip_s is None else f"{trip_s * 1000:.1f} ms"
        texts = {
            "port": tr("{port}, {rate} baud", port=evidence.port, rate=evidence.baud_rate) if evidence.port else "—",
            "bytes": f"{counters.bytes_received:,}",
            "frames": " · ".join(parts),
            "replies": f"{trip} · {labelled(tr('Without reply'), lost)}",
            "noise": evidence.noise[-16:].hex(" ").upper() or "—",
        }
        for key, text in texts.items():
            self.checked[key].setText(text)

    def _do(self) -> None:
        match self._step:
            case NextStep.COPY_COMMAND if self.diagnosis is not None:
                QGuiApplication.clipboard().setText(self.diagnosis.command)
            case NextStep.CONNECT_AGAIN if self._ports.current.target is not None:
                self._page.connect_wanted.emit(self._ports.current.target)
            case NextStep.FIND_RATE:
                self._ports.current.find_rate()
            case _:
                self._page.ports_wanted.emit()


class SharingCard(QFrame):
    """A card on sharing the port that the window shows."""

    def __init__(self, services: Services) -> None:
        super().__init__()
        named(self, "sharing_card", "card")
        self._ports = services.ports
        self.switch = control(QCheckBox(tr("Share this port, read-only")), "sharing_switch", slot=self._press)
        self.address = named(QLineEdit("127.0.0.1:7001"), "sharing_address", says=tr("Address for readers"))
        self.state = text_label("sharing_state", "muted", is_selectable=True)
        self.last = figure("sharing_last", self.switch.text())
        head = in_row(self.switch, (self.address, 1), spacing=Space.M)
        in_column(head, self.state, self.last, of=self, spacing=Space.S)
        self._ports.changed.connect(self._show)
        self._ports.shown.connect(self._show)
        for port in self._ports.all:
            port.sharing.changed.connect(self._show)
        self._ports.added.connect(lambda port: port.sharing.changed.connect(self._show))
        self._show()

    def _press(self, is_on: bool) -> None:
        sharing = self._ports.current.sharing
        sharing.start(self.address.text()) if is_on else sharing.stop()
        self._show()

    def _show(self) -> None:
        sharing = self._ports.current.sharing
        is_on = sharing.address != ""
        self.switch.setChecked(is_on)
        self.switch.setEnabled(is_on or self._ports.current.is_open)
        self.address.setEnabled(not is_on)
        text = tr("Other programs on this computer may ask, and may send LOCK. TCP has no authentication.")
        if is_on:
            text = join_names((sharing.address, tr("readers: {count}", count=sharing.readers)))
        self.state.setText(text)
        self.last.setText(sharing.last)
        set_role(self.last, "attention" if sharing.meaning is Meaning.ATTENTION else "")
