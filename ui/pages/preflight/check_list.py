"""Scrolling list of checks and manual items."""

from collections.abc import Mapping
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QFrame, QScrollArea, QVBoxLayout, QWidget

from app.preflight.checks import CHECKS
from app.preflight.verdict import VALID_FOR_S
from app.settings.profiles import ManualLine
from ui.core.texts import Texts
from ui.pages.preflight.controller import PreflightController, Standing, Statement
from ui.pages.preflight.row import CheckRow, ManualRow
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.layouts import in_column
from ui.widgets.naming import named

STATEMENTS: Final = {
    "attitude_trigger": Statement(is_enabling=True),
    "freefall_trigger": Statement(is_enabling=True),
    "trigger_records": Statement(are_records_looked_at=True),
    "boot_count": Statement(is_same_module=True),
}
"""What a click in a row says."""


class CheckList(QScrollArea):
    """`check_wanted`: a `Statement` to check again with. `ticked`: a manual item was ticked, or its tick taken back."""

    check_wanted = Signal(object)
    ticked = Signal()

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        named(self, "preflight_scroll")
        self._texts = texts
        self._ticks: dict[int, tuple[bool, float]] = {}
        """By the item's number: whether it is in order, and when that was said, in the connector's seconds."""
        self.rows = {check.id: CheckRow(check, texts) for check in CHECKS}
        self.manual: list[ManualRow] = []
        self._manual_card, self._manual_rows = _card("preflight_manual")
        self._manual_card.hide()
        self.explain = control(QCheckBox(), texts, "preflight_explain", "Explain every check",
                               tip="Say why each check matters, also where it passes")  # fmt: skip
        card, rows = _card("preflight_checks")
        for row in self.rows.values():
            rows.addWidget(row)
            row.act_wanted.connect(self._act)
        content = QWidget()
        content.setObjectName("preflight_content")
        in_column(
            self._manual_card,
            self.explain,
            card,
            1,
            of=content,
            spacing=Space.S,
            margins=(Space.M, 0, Space.M, Space.S),
        )
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setWidget(content)
        texts.bind(self.setAccessibleName, "Checks")
        self.now = 0.0
        """When a tick is made; the page keeps it."""

    @property
    def ticks(self) -> Mapping[int, bool]:
        return {number: is_done for number, (is_done, _at) in self._ticks.items()}

    def use_manual(self, lines: tuple[ManualLine, ...]) -> None:
        """Other items: what was ticked before was said of others."""
        self._ticks.clear()
        for row in self.manual:
            self._manual_rows.removeWidget(row)
            row.hide()
            row.deleteLater()
        self.manual = [ManualRow(number, line, self._texts) for number, line in enumerate(lines, 1)]
        for row in self.manual:
            row.ticked.connect(self._tick)
            self._manual_rows.addWidget(row)
        self._manual_card.setVisible(bool(self.manual))

    def forget_ticks(self) -> None:
        self._ticks.clear()

    def forget_old_ticks(self) -> bool:
        """What somebody looked at long ago was for another flight; whether there was such a tick."""
        old = [number for number, (_is_done, at) in self._ticks.items() if self.now - at > VALID_FOR_S]
        for number in old:
            del self._ticks[number]
        return bool(old)

    def show_work(self, work: PreflightController) -> None:
        assessment, standing = work.assessment, work.standing
        judged = {} if assessment is None else {one.check.id: one for one in assessment.checks}
        is_checking, is_explained = standing is Standing.CHECKING, self.explain.isChecked()
        for id_, row in self.rows.items():
            found = judged.get(id_)
            if found is None:
                row.show_waiting(is_checking=is_checking, is_explained=is_explained or not is_checking)
            else:
                is_void = standing is Standing.VOID
                row.show_judged(found, is_void=is_void, is_explained=is_explained, can_act=work.can_check)
        for item in self.manual:
            item.show_state(self.ticks.get(item.number), can_tick=not is_checking)

    def allow_acts(self, is_allowed: bool) -> None:
        for row in self.rows.values():
            row.act.setEnabled(is_allowed)

    def show_row(self, id_: str) -> None:
        """Scroll to where the row of a check is in sight."""
        self.ensureWidgetVisible(self.rows[id_], 0, Space.XL)

    def _act(self, id_: str) -> None:
        self.check_wanted.emit(STATEMENTS[id_])

    def _tick(self, number: int, state: bool | None) -> None:
        self._ticks.pop(number, None)
        if state is not None:
            self._ticks[number] = (state, self.now)
        self.ticked.emit()


def _card(name: str) -> tuple[QFrame, QVBoxLayout]:
    card = named(QFrame(), name, "card")
    return card, in_column(of=card, spacing=0, margins=1)
