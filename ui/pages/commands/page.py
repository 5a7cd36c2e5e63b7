"""Commands page: the state, then the acts from safe to dangerous; deploying docked below."""

from collections.abc import Mapping
from typing import Final

from PySide6.QtWidgets import QFrame, QPushButton, QStackedLayout, QWidget

from app.procedures.lock import SENTENCES
from app.safety.acts import TITLES, Act
from app.safety.journal import Outcome
from app.safety.last_known import Activation
from app.text.i18n import tr
from protocol.translatable import marked
from ui.acts.act_row import ActRow
from ui.acts.ritual_widget import RitualWidget
from ui.services.context import Services
from ui.services.page import Page
from ui.style.icons import Icon, set_icon_size
from ui.style.theme import Meaning, Size, Space, scaled
from ui.widgets.controls import TEXT_GAP_PX, control
from ui.widgets.labels import FittedLabel, text_label
from ui.widgets.layouts import in_column, in_row, scroll_area
from ui.widgets.naming import named, set_role
from ui.widgets.notice_bar import Notice, NoticeBar
from ui.widgets.readout import StateChip
from ui.widgets.state_chips import show_activation, show_known_trigger
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 200
_CHIP_PX: Final = 40
"""With room for the age of a stale state below its word."""
_NOTICE_PX: Final = 40
OPERATION: Final = (Act.ACTIVATE,)
MAINTENANCE: Final = (Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY)
STATE_WORDS: Final[Mapping[Activation, str]] = {
    Activation.ACTIVE: marked("Ready to fire: lock it before you touch it."),
    Activation.WAS_ACTIVE: marked("Treat it as ready to fire until it reports LOCKED."),
    Activation.LOCKED: marked("In standby."),
    Activation.WAS_LOCKED: marked("Treat it as ready to fire until it reports LOCKED."),
    Activation.UNKNOWN: marked("Treat it as ready to fire until it reports LOCKED."),
}
"""What the reported state means for the person beside the module."""


class CommandsPage(Page):
    """See the module's docstring."""

    def __init__(self, services: Services) -> None:
        super().__init__("commands")
        self._services, self._connector = services, services.connector
        texts = services.texts
        self.activation = named(StateChip("", size=Size.TITLE, is_stacked=True), "commands_activation")
        self.trigger = named(StateChip("", size=Size.TITLE, is_stacked=True), "commands_trigger")
        texts.bind(self.activation.name_unknown, "Activation unknown")
        texts.bind(self.trigger.name_unknown, "Trigger unknown")
        self.meaning = named(FittedLabel(is_bold=True), "commands_state_meaning")
        self.lock = control(QPushButton(), texts, "commands_lock", "LOCK", says="Lock",
                            tip="Lock", key="Ctrl+L", picture=Icon.LOCK,
                            role="primary")  # fmt: skip
        set_icon_size(self.lock, 20, gap_px=TEXT_GAP_PX)
        services.lock.bind(self.lock)
        self.said = named(NoticeBar(texts), "commands_said")
        # Stacked, and of a fixed height: neither a notice nor another state moves the acts below.
        self._lock_words, self._lock_title = QStackedLayout(), text_label("commands_lock_title", "strong")
        self.acts = {act: ActRow(services, act) for act in (*OPERATION, *MAINTENANCE)}
        self.ritual = RitualWidget(services)
        self._lay_out()
        timer = VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS)
        self._connector.changed.connect(timer.refresh_seen)
        services.lock.changed.connect(timer.refresh_seen)
        self.refresh()

    def refresh(self) -> None:
        self._show_state()
        for row in self.acts.values():
            row.refresh()
        self.ritual.refresh()
        notice = self._notice()
        for one in (self._lock_title, self.said):
            one.setMinimumHeight(scaled(_NOTICE_PX))
        self.said.show_notice(notice)
        self._lock_words.setCurrentWidget(self._lock_title if notice is None else self.said)

    def _show_state(self) -> None:
        device, now = self._connector.device, self._connector.clock()
        self.activation.set_caption(tr("Activation"))
        self.trigger.set_caption(tr("Trigger"))
        show_activation(self.activation, self._connector.activation, now)
        self.meaning.show_text(tr(STATE_WORDS[self._connector.activation.state]))
        show_known_trigger(self.trigger, device.known("triggered", now), now)
        for chip in (self.activation, self.trigger):
            chip.setFixedHeight(scaled(_CHIP_PX))

    def _notice(self) -> Notice | None:
        lock = self._services.lock
        if lock.is_reported:
            return Notice(Meaning.GOOD, tr(SENTENCES[Outcome.CONFIRMED]))
        return lock.notice()

    def _lay_out(self) -> None:
        texts = self._services.texts
        state = in_row(self.activation, self.trigger, (self.meaning, 1), spacing=Space.M)
        safe = named(QFrame(), "commands_safe", "card")
        texts.bind(self._lock_title.setText, TITLES[Act.LOCK])
        for one in (self._lock_title, self.said):
            self._lock_words.addWidget(one)
        in_row((self._lock_words, 1), self.lock, of=safe, spacing=Space.L, margins=(Space.M, 1))
        groups = (
            (marked("Make safe"), safe),
            (marked("Operation"), self._corner("commands_operation", OPERATION)),
            (marked("Maintenance"), self._corner("commands_maintenance", MAINTENANCE)),
        )
        column = in_column(state, spacing=Space.XS, margins=(Space.M, 0, Space.M, Space.S))
        for english, frame in groups:
            caption = text_label(f"{frame.objectName()}_caption", "caption")
            texts.bind(caption.setText, english)
            column.addSpacing(Space.XS)
            column.addWidget(caption)
            column.addWidget(frame)
        column.addStretch(1)
        content = named(QWidget(), "commands_content")
        content.setLayout(column)
        scroll = scroll_area(content, texts, "commands_scroll", "Commands")
        head = in_column(self.make_header(texts, marked("Commands")), margins=(Space.M, 0))
        docked = in_column(self.ritual, margins=(Space.M, Space.XS, Space.M, Space.S))
        in_column(head, (scroll, 1), docked, of=self, spacing=0, margins=0)

    def _corner(self, name: str, acts: tuple[Act, ...]) -> QFrame:
        corner = named(QFrame(), name, "danger-corner")
        in_column(*(self.acts[act] for act in acts), of=corner, spacing=0, margins=2)
        set_role(self.acts[acts[-1]], "")  # no line below the last
        return corner
