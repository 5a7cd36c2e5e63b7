"""Commands page: LOCK at the top, dangerous acts framed below."""

from typing import Final

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QFrame, QPushButton, QScrollArea, QWidget

from app.safety.acts import EFFECTS, Act
from app.text.i18n import tr
from ui.acts.act_row import ActRow
from ui.acts.ritual_widget import RitualWidget
from ui.services.context import Services
from ui.services.page import Page
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space
from ui.widgets.controls import control
from ui.widgets.labels import text_label
from ui.widgets.layouts import FlowRow, Gap, in_column
from ui.widgets.naming import named
from ui.widgets.notice_bar import Notice, NoticeBar
from ui.widgets.readout import StateChip
from ui.widgets.state_chips import show_activation, show_known_trigger
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 200
DANGEROUS: Final = (Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY)


class CommandsPage(Page):
    """See the module's docstring."""

    def __init__(self, services: Services, parent: QWidget | None = None) -> None:
        super().__init__("commands", parent)
        self._services, self._connector = services, services.connector
        texts = services.texts
        self.activation = named(StateChip("", size=Size.TITLE), "commands_activation")
        self.trigger = named(StateChip("", size=Size.TITLE), "commands_trigger")
        texts.bind(self.activation.name_unknown, "Activation unknown")
        texts.bind(self.trigger.name_unknown, "Trigger unknown")
        self.lock = control(QPushButton(), texts, "commands_lock", "LOCK", says="Lock the module",
                            tip="Put the module into standby, at once", key="Ctrl+L", picture=Icon.LOCK,
                            role="primary")  # fmt: skip
        self.lock.setIconSize(QSize(20, 20))
        services.lock.bind(self.lock)
        self.said = NoticeBar(texts)
        self.said.setObjectName("commands_said")
        self.acts = {act: ActRow(services, act) for act in DANGEROUS}
        self.ritual = RitualWidget(services)
        self._lay_out()
        VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS)
        self._connector.changed.connect(self.refresh)
        services.lock.changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        self._show_state()
        for row in self.acts.values():
            row.refresh()
        self.ritual.refresh()
        self.said.show_notice(self._notice())

    def _show_state(self) -> None:
        device, now = self._connector.device, self._connector.clock()
        self.activation.set_caption(tr("Activation"))
        self.trigger.set_caption(tr("Trigger"))
        show_activation(self.activation, self._connector.activation, now)
        show_known_trigger(self.trigger, device.known("triggered", now), now)

    def _notice(self) -> Notice | None:
        lock = self._services.lock
        if lock.confirmed is not None:
            return Notice(Meaning.GOOD, lock.confirmed.sentence)
        return lock.notice()

    def _lay_out(self) -> None:
        texts = self._services.texts
        card = named(QFrame(), "commands_state", "card")
        row = FlowRow(spacing_px=Space.M)
        row.add(self.activation, self.trigger)
        row.add_right(self.lock)
        effect = text_label("commands_lock_effect", "small")
        texts.bind(effect.setText, EFFECTS[Act.LOCK])
        in_column(row, effect, self.said, of=card, spacing=Space.XS, margins=Space.M)
        heading = text_label("commands_danger_heading", "caption")
        texts.bind(heading.setText, "Dangerous: each asks again, is written into the log first, and is sent once")
        corner = named(QFrame(), "commands_danger", "danger-corner")
        in_column(*self.acts.values(), of=corner, spacing=0, margins=2)
        content = named(QWidget(), "commands_content")
        in_column(card, Gap(Space.M), heading, corner, 1, of=content, spacing=Space.S, margins=(Space.M, Space.S))
        scroll = control(QScrollArea(), texts, "commands_scroll", says="Commands")
        scroll.setWidgetResizable(True)
        scroll.setWidget(content)
        docked = in_column(self.ritual, margins=(Space.M, Space.XS, Space.M, Space.S))
        in_column((scroll, 1), docked, of=self, spacing=0, margins=0)
