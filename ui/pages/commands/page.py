"""Commands page: what the state means, the acts in their groups, deploying docked below and alone in red.

The state itself, its age and LOCK stand in the top bar.
"""

from typing import Final

from PySide6.QtWidgets import QFrame, QWidget

from app.safety.journal import Act
from app.safety.last_known import Activation
from app.text.i18n import tr
from ui.acts.act_row import ActRow
from ui.acts.ritual_widget import RitualWidget
from ui.services.context import Services
from ui.services.page import Page
from ui.style.theme import Space, is_text_large
from ui.widgets.controls import in_column, named, scroll_area, set_role, text_label
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 200


class CommandsPage(Page):
    def __init__(self, services: Services) -> None:
        super().__init__("commands")
        self.meaning = text_label("commands_state_meaning", "strong")
        self.acts: dict[Act, ActRow] = {}
        self.ritual = RitualWidget(services)
        column = in_column(self.meaning, spacing=Space.XS, margins=(Space.M, 0, Space.M, Space.S))
        groups = (
            ("commands_operation", tr("Operation"), (Act.ACTIVATE,)),
            ("commands_maintenance", tr("Maintenance"), (Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY)),
        )
        for name, title, acts in groups:
            caption = text_label(f"{name}_caption", "caption", title)
            card = named(QFrame(), name, "card")
            rows = [ActRow(services, act) for act in acts]
            self.acts |= zip(acts, rows, strict=True)
            in_column(*rows, of=card, spacing=0, margins=2)
            set_role(rows[-1], "")  # no line below the last
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
        """Show what the reported state means for the person beside the module."""
        module = self.module
        state, fired = module.activation.state, module.view.known("triggered", module.now_s)
        is_locked = state is Activation.LOCKED
        if fired is not None and fired.value is True:
            text = tr("Fired. Treat it as ready to fire until it reports LOCKED.")
            text = tr("Fired. Find out why (Triggers), repack, restart.") if is_locked else text
        elif state is Activation.ACTIVE:
            text = tr("Ready to fire: lock it before you touch it.")
        else:
            text = tr("Treat it as ready to fire until it reports LOCKED.")
            text = tr("The module is LOCKED.") if is_locked else text
        self.meaning.setText(text)
        for row in self.acts.values():
            row.refresh()
        self.ritual.refresh()
