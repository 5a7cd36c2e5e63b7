"""Scrolling list: what failed with its action, then the manual checks, then what passed, folded."""

from itertools import pairwise

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QLabel, QToolButton, QWidget

from app.preflight.findings import CheckResult
from app.preflight.verdict import CHECKS, VALID_FOR_S
from app.settings.profiles import NO_PROFILE, Profile
from app.text.i18n import tr
from ui.pages.preflight.controller import PreflightController
from ui.pages.preflight.row import CheckRow, ManualRow, remedy
from ui.services.context import Services
from ui.session.check import Standing
from ui.style.icons import Icon, icon
from ui.style.theme import Space
from ui.widgets.controls import control, named
from ui.widgets.layouts import ScrollArea, in_column


class CheckList(ScrollArea):
    """`mend_wanted`: the `Remedy` of a row. `ticked`: a manual item was ticked or unticked."""

    mend_wanted = Signal(object)
    ticked = Signal()

    def __init__(self, services: Services) -> None:
        super().__init__()
        named(self, "preflight_scroll")
        self._ports = services.ports
        self._profile: Profile | None = None
        self._ticks: dict[int, tuple[bool, float]] = {}
        """By the item's number: whether it is OK, and when it was ticked, in seconds of the connector."""
        self.rows = {check.id: CheckRow(check) for check in CHECKS}
        self.manual: list[ManualRow] = []
        self._shown: tuple[object, ...] = ()
        """What the rows were last written for."""
        self._order: list[str] = []
        """Ids of the checks that did not pass."""
        self._failed = _Section("preflight_failed")
        self._manual = _Section("preflight_manual")
        self._passed = _Section("preflight_passed")
        self.fold = control(QToolButton(), "preflight_fold", is_checkable=True, role="quiet")
        self.fold.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.fold.toggled.connect(self._show_fold)
        for row in self.rows.values():
            self._passed.rows.addWidget(row)
            row.act_wanted.connect(self.mend_wanted)
        content = named(QWidget(), "preflight_content")
        in_column(
            self._failed,
            self._manual,
            (self.fold, Qt.AlignmentFlag.AlignLeft),
            self._passed.card,
            1,
            of=content,
            spacing=Space.XS,
            margins=(Space.M, 0, Space.M, Space.S),
        )
        self._show_fold()
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setWidget(content)
        self.setAccessibleName(tr("Pre-flight"))

    def answered(self) -> Profile:
        ticks = {number: is_done for number, (is_done, _at) in self._ticks.items()}
        return NO_PROFILE if self._profile is None else self._profile.answered(ticks)

    def use_profile(self, profile: Profile | None) -> None:
        """Show the items of another profile, none of them ticked; with another approved code it is the same one."""
        before, self._profile = self._profile, profile
        if _without_code(before) == _without_code(profile):
            return
        self._ticks.clear()
        for row in self.manual:
            self._manual.rows.removeWidget(row)
            row.hide()
            row.deleteLater()
        lines = () if profile is None else profile.manual
        self.manual = [ManualRow(number, line) for number, line in enumerate(lines, 1)]
        for row in self.manual:
            row.ticked.connect(self._tick)
            self._manual.rows.addWidget(row)
        self._manual.setVisible(bool(self.manual))

    def clear_ticks(self) -> None:
        self._ticks.clear()

    def clear_old_ticks(self) -> bool:
        """Remove ticks that were made for an earlier flight; whether there were any."""
        before, now = len(self._ticks), self._ports.clock()
        self._ticks = {number: tick for number, tick in self._ticks.items() if now - tick[1] <= VALID_FOR_S}
        return len(self._ticks) < before

    def show_work(self, work: PreflightController) -> None:
        """Show the results, unless they are shown already: signals come many times during a check."""
        assessment, standing = work.assessment, work.standing
        looked_at = self._ports.module.looked_at
        shown = (assessment, standing, work.needs_lock, self._profile, self._ticks.copy(), looked_at.copy())
        if shown == self._shown:
            return
        self._shown = shown
        judged = {} if assessment is None else {check.check.id: check for check in assessment.checks}
        is_checking, is_void = standing is Standing.CHECKING, standing is Standing.VOID
        failed = [id_ for id_, check in judged.items() if check.finding.result is not CheckResult.PASS]
        failed.sort(key=lambda id_: not judged[id_].blocks_go)  # warnings after what is against GO
        self._sort(failed)
        for id_, row in self.rows.items():
            check = judged.get(id_)
            if assessment is None or check is None:
                row.show_waiting(is_checking=is_checking)
            else:
                has_profile = self._profile is not None
                act = remedy(
                    check, assessment.case, has_profile=has_profile, needs_lock=work.needs_lock, looked_at=looked_at
                )
                # What is said of a void result would count for whatever module answers now.
                row.show_judged(check, None if is_void else act, is_void=is_void)
        for item in self.manual:
            state, _at = self._ticks.get(item.number, (None, 0.0))
            item.show_state(state, can_tick=not is_checking)
        passed = len(self.rows) - len(failed)
        against = sum(judged[id_].blocks_go for id_ in failed)
        titles = [tr("Not met: {names}", names=against)] if against else []
        if len(failed) > against:
            titles.append(tr("Warnings: {count}", count=len(failed) - against))
        self._failed.show_title(" · ".join(titles))
        self._manual.show_title(tr("Manual checks"))
        self.fold.setText(tr("{count} passed", count=passed) if judged else tr("Checks: {count}", count=passed))

    def _sort(self, failed: list[str]) -> None:
        """Show what did not pass at the top and the rest below the fold, each in its order."""
        if failed == self._order:
            return
        self._order = failed
        for section, ids in ((self._failed, failed), (self._passed, [id_ for id_ in self.rows if id_ not in failed])):
            for id_ in ids:
                section.rows.addWidget(self.rows[id_])
        self._failed.setVisible(bool(failed))
        for before, after in pairwise((*failed, *(id_ for id_ in self.rows if id_ not in failed))):
            self.setTabOrder(self.rows[before].act, self.rows[after].act)

    def _show_fold(self) -> None:
        is_open = self.fold.isChecked()
        self.fold.setIcon(icon(Icon.CHEVRON_DOWN if is_open else Icon.CHEVRON_RIGHT))
        self._passed.card.setVisible(is_open)

    def _tick(self, number: int, state: bool | None) -> None:
        self._ticks.pop(number, None)
        if state is not None:
            self._ticks[number] = (state, self._ports.clock())
        self.ticked.emit()


class _Section(QWidget):
    """A heading above a card with rows; hidden at first."""

    def __init__(self, name: str) -> None:
        super().__init__()
        named(self, f"{name}_section")
        self._title = named(QLabel(), f"{name}_title", "caption")
        self.card = named(QFrame(), f"{name}_checks", "card")
        self.rows = in_column(of=self.card, spacing=0, margins=1)
        in_column(self._title, self.card, of=self, spacing=Space.XS, margins=0)
        self.hide()

    def show_title(self, text: str) -> None:
        self._title.setText(text)


def _without_code(profile: Profile | None) -> Profile | None:
    return None if profile is None else profile._replace(approved_fingerprint=None)
