"""Commands page: what the state means, the acts in their groups, deploying docked below and alone in red.

The state itself, its age and LOCK stand in the top bar.
"""

from collections.abc import Mapping
from typing import Final

from PySide6.QtWidgets import QFrame, QWidget

from app.safety.journal import Act
from app.safety.last_known import Activation
from app.text.i18n import tr
from protocol.translatable import marked
from ui.acts.act_row import ActRow
from ui.acts.ritual_widget import RitualWidget
from ui.services.context import Services
from ui.services.page import Page
from ui.style.theme import Space, is_text_large
from ui.widgets.controls import in_column, named, scroll_area, set_role, text_label
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 200
GROUPS: Final = (
    ("commands_operation", marked("Operation"), (Act.ACTIVATE,)),
    ("commands_maintenance", marked("Maintenance"), (Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY)),
)
STATE_WORDS: Final[Mapping[Activation, str]] = {
    Activation.ACTIVE: marked("Ready to fire: lock it before you touch it."),
    Activation.WAS_ACTIVE: marked("Treat it as ready to fire until it reports LOCKED."),
    Activation.LOCKED: marked("The module is LOCKED."),
    Activation.WAS_LOCKED: marked("Treat it as ready to fire until it reports LOCKED."),
    Activation.UNKNOWN: marked("Treat it as ready to fire until it reports LOCKED."),
}
"""What the reported state means for the person beside the module."""
FIRED_WORDS: Final[Mapping[bool, str]] = {
    True: marked("Fired. Find out why (Triggers), repack, restart."),
    False: marked("Fired. Treat it as ready to fire until it reports LOCKED."),
}
"""Where it last reported that it is triggered, by whether it reports LOCKED."""


class CommandsPage(Page):
    def __init__(self, services: Services) -> None:
        super().__init__("commands")
        self.meaning = text_label("commands_state_meaning", "strong")
        self.acts = {act: ActRow(services, act) for _name, _title, acts in GROUPS for act in acts}
        self.ritual = RitualWidget(services)
        column = in_column(self.meaning, spacing=Space.XS, margins=(Space.M, 0, Space.M, Space.S))
        for name, title, acts in GROUPS:
            caption = text_label(f"{name}_caption", "caption")
            caption.setText(tr(title))
            card = named(QFrame(), name, "card")
            in_column(*(self.acts[act] for act in acts), of=card, spacing=0, margins=2)
            set_role(self.acts[acts[-1]], "")  # no line below the last
            column.addSpacing(Space.XS)
            column.addWidget(caption)
            column.addWidget(card)
        column.addStretch(1)
        content = named(QWidget(), "commands_content")
        content.setLayout(column)
        # In large text the page scrolls as a whole: an area of its own would show no act.
        scroll = content if is_text_large() else scroll_area(content, "commands_scroll", tr("Commands"))
        head = in_column(self.make_header(tr("Commands")), margins=(Space.M, 0))
        docked = in_column(self.ritual, margins=(Space.M, Space.XS, Space.M, Space.S))
        in_column(head, (scroll, 1), docked, of=self, spacing=0, margins=0)
        VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS)

    def refresh(self) -> None:
        module = self.module
        activation = module.activation
        fired = module.view.known("triggered", module.now_s)
        has_fired = fired is not None and fired.value is True
        is_locked = activation.state is Activation.LOCKED
        self.meaning.setText(tr(FIRED_WORDS[is_locked] if has_fired else STATE_WORDS[activation.state]))
        for row in self.acts.values():
            row.refresh()
        self.ritual.refresh()
