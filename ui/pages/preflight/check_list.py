"""The list of checks: what did not pass with the button that mends it, the manual checks, then what passed, folded."""

from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QButtonGroup, QFrame, QGridLayout, QLabel, QToolButton, QWidget

from app.preflight.findings import RESULT_WORDS, Check, CheckResult
from app.preflight.verdict import CHECKS, MANUAL_WORDS, VALID_FOR_S, Judged
from app.settings.profiles import NO_PROFILE, ManualLine, Profile
from app.text.i18n import tr
from app.text.messages import clean
from ui.pages.preflight.controller import PreflightController
from ui.pages.preflight.remedy import Mend, Remedy, remedy
from ui.services.context import Services
from ui.session.check import Standing
from ui.style.icons import Icon, StateStyle, icon
from ui.style.theme import IconSize, Meaning, Size, Space, font
from ui.widgets.controls import ChoiceButton, named, set_role
from ui.widgets.labels import IconLabel, text_label
from ui.widgets.layouts import ScrollArea, in_column, in_row
from ui.widgets.step_button import StepButton

_STYLES: Final = {
    CheckResult.PASS: StateStyle(Icon.CHECK, Meaning.GOOD),
    CheckResult.FAIL: StateStyle(Icon.CROSS, Meaning.DANGER),
    CheckResult.WARN: StateStyle(Icon.WARNING, Meaning.ATTENTION),
    CheckResult.UNKNOWN: StateStyle(Icon.UNKNOWN, Meaning.UNKNOWN),
}
_MANUAL_STYLES: Final = {
    True: StateStyle(Icon.CHECK, Meaning.GOOD),
    False: StateStyle(Icon.CROSS, Meaning.DANGER),
    None: StateStyle(Icon.UNKNOWN, Meaning.UNKNOWN),
}


class _Row(QFrame):
    """State, title and two columns, which stretch in the same way in every row."""

    def __init__(self, name: str) -> None:
        super().__init__()
        named(self, name, "marked-row")
        self.mark = IconLabel(f"{name}_mark", IconSize.STATE, keeps_place=True)
        self.word = named(QLabel(), f"{name}_result", "small")
        # The columns of all rows begin at the same place.
        words = [tr(word) for word in (*RESULT_WORDS.values(), *MANUAL_WORDS.values())]
        self.word.setMinimumWidth(max(map(QFontMetrics(font(Size.SMALL, is_bold=True)).horizontalAdvance, words)))
        self.title = text_label(f"{name}_title", "strong")
        self.grid = QGridLayout(self)
        self.grid.setContentsMargins(Space.S, Space.XS, Space.M, Space.XS)
        self.grid.setHorizontalSpacing(Space.S)
        self.grid.setVerticalSpacing(0)
        for column, share in ((2, 4), (3, 3), (4, 4)):
            self.grid.setColumnStretch(column, share)
        for column, part in enumerate((self.mark, self.word, self.title)):
            self.grid.addWidget(part, 0, column)

    def show_style(self, style: StateStyle, word: str, *, is_failed: bool, is_muted: bool = False) -> None:
        self.mark.show_icon(style.icon, style.meaning, is_muted=is_muted or style.meaning is None)
        self.word.setText(word)
        loud = {Meaning.DANGER: "danger", Meaning.ATTENTION: "attention"}
        set_role(self.word, "small" if is_muted or style.meaning is None else loud.get(style.meaning, "small"))
        set_role(self, "marked-row-failed" if is_failed else "marked-row")


class CheckRow(_Row):
    """Before a check it shows what is checked and why. `act_wanted`: the `Remedy` of its button."""

    act_wanted = Signal(object)

    def __init__(self, check: Check) -> None:
        name = f"check_{check.id}"
        super().__init__(name)
        self.check = check
        self.measured = text_label(f"{name}_measured")
        self.limit = text_label(f"{name}_limit", "muted")
        self.reason = text_label(f"{name}_why", "small")
        # A step: the end of a check moves its rows, and what comes to lie under the pointer then was not chosen.
        self.act = named(StepButton(), f"{name}_act")
        self.act.chosen.connect(self._on_act)
        policy = self.act.sizePolicy()
        policy.setRetainSizeWhenHidden(False)
        self.act.setSizePolicy(policy)
        self._act: Remedy | None = None
        self.title.setText(tr(check.title))
        self.grid.addWidget(self.measured, 0, 3)
        self.grid.addWidget(self.limit, 0, 4)
        self.grid.addLayout(in_row((self.reason, 1), self.act, spacing=Space.M), 1, 2, 1, 3)

    @property
    def is_enabling(self) -> bool:
        """Its button enables the triggers."""
        return self._act is not None and self._act.mend is Mend.ENABLE

    def _on_act(self) -> None:
        if self._act is not None:
            self.act_wanted.emit(self._act)

    def show_waiting(self, *, is_checking: bool) -> None:
        self.show_style(StateStyle(Icon.CONNECTING if is_checking else Icon.UNKNOWN, None), "", is_failed=False)
        self.measured.setText("")
        self.limit.setText("")
        state = tr("checking…") if is_checking else tr("not checked")  # for the eye the verdict says it
        self._show(tr(self.check.why), None, is_explained=not is_checking, state=state)

    def show_judged(self, judged: Judged, act: Remedy | None, *, is_void: bool) -> None:
        finding = judged.finding
        word = tr(RESULT_WORDS[finding.result])
        # A void result can still be read, but is dimmed and marked as void.
        word = f"{word}\n{tr('void')}" if is_void else word
        is_failed = judged.blocks_go and not is_void
        self.show_style(_STYLES[finding.result], word, is_failed=is_failed, is_muted=is_void)
        self.measured.setText(finding.shown.translated())
        self.limit.setText(finding.limit.translated())
        is_fine = finding.result is CheckResult.PASS
        set_role(self.measured, "muted" if is_void else "" if is_fine else "strong")
        do = "" if is_fine else f" → {judged.do.translated()}"
        self._show(f"{tr(self.check.why)}{do}", act, is_explained=not is_fine, state=word.replace("\n", " · "))

    def _show(self, reason: str, act: Remedy | None, *, is_explained: bool, state: str = "") -> None:
        self._act = act
        words = tr(act.words) if act is not None else ""
        self.act.setText(words)
        self.act.setAccessibleName(f"{words}: {self.title.text()}")
        self.act.setVisible(act is not None)
        self.reason.setText(reason)
        self.reason.setVisible(is_explained)
        self.setToolTip(reason)
        parts = (self.title.text(), state or self.word.text(), self.measured.text(), self.limit.text())
        self.setAccessibleName(", ".join(part for part in parts if part))
        self.setAccessibleDescription(reason)


class ManualRow(_Row):
    """Done, not OK, or skipped. `ticked`: the number and True, False or None."""

    ticked = Signal(int, object)

    def __init__(self, number: int, line: ManualLine) -> None:
        name = f"manual_{number}"
        super().__init__(name)
        self.number, self.line = number, line
        self.state: bool | None = None
        self.title.setText(clean(line.text))
        need = text_label(f"{name}_need", "muted")
        need.setText(tr("required") if line.is_required else tr("optional"))
        self.grid.addWidget(need, 0, 3)
        buttons = QButtonGroup(self)
        buttons.setExclusive(False)
        self.done, self.bad = named(ChoiceButton(), f"{name}_done"), named(ChoiceButton(), f"{name}_bad")
        for button, text, state in ((self.done, tr("OK"), True), (self.bad, tr("Not OK"), False)):
            button.setText(text)
            buttons.addButton(button)
            button.clicked.connect(lambda is_on, state=state: self._tick(state if is_on else None))
        self.grid.addLayout(in_row(1, self.done, self.bad, spacing=Space.S), 0, 4)
        self.show_state(None)

    def show_state(self, state: bool | None, *, can_tick: bool = True) -> None:
        self.state = state
        self.show_style(_MANUAL_STYLES[state], tr(MANUAL_WORDS[state]), is_failed=state is False)
        for button, is_on in ((self.done, state is True), (self.bad, state is False)):
            button.setChecked(is_on)
            button.setEnabled(can_tick)
        self.setAccessibleName(f"{self.title.text()}, {self.word.text()}")

    def _tick(self, state: bool | None) -> None:
        self.show_state(state)
        self.ticked.emit(self.number, state)


class CheckList(ScrollArea):
    """`mend_wanted`: the `Remedy` of a row. `ticked`: a manual item was ticked or unticked."""

    mend_wanted = Signal(object)
    ticked = Signal()

    def __init__(self, services: Services) -> None:
        super().__init__()
        named(self, "preflight_scroll").setAccessibleName(tr("Pre-flight"))
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._ports = services.ports
        self._profile: Profile | None = None
        self._ticks: dict[int, tuple[bool, float]] = {}
        """By the item's number: whether it is OK, and when it was ticked, in seconds of the connector."""
        self.rows = {check.id: CheckRow(check) for check in CHECKS}
        self.manual: list[ManualRow] = []
        self._shown: tuple[object, ...] = ()
        """What the rows were last written for."""
        self._failed_title = named(QLabel(), "preflight_failed_title", "caption")
        self._manual_title = named(QLabel(tr("Manual checks")), "preflight_manual_title", "caption")
        self.fold = named(QToolButton(), "preflight_fold", "quiet")
        self.fold.setCheckable(True)
        self.fold.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.fold.toggled.connect(self._show_fold)
        self._cards = [named(QFrame(), f"preflight_{name}_checks", "card") for name in ("failed", "manual", "passed")]
        self._failed, self._manual, self._passed = (in_column(of=card, spacing=0, margins=1) for card in self._cards)
        for row in self.rows.values():
            self._passed.addWidget(row)
            row.act_wanted.connect(self.mend_wanted)
        for part in (self._failed_title, self._manual_title, *self._cards[:2]):
            part.hide()
        content = named(QWidget(), "preflight_content")
        failed, manual, passed = self._cards
        parts = (
            self._failed_title,
            failed,
            self._manual_title,
            manual,
            (self.fold, Qt.AlignmentFlag.AlignLeft),
            passed,
        )
        self.column = in_column(*parts, 1, of=content, spacing=Space.XS, margins=(Space.M, 0, Space.M, Space.S))
        self.setWidget(content)

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
            self._manual.removeWidget(row)
            row.hide()
            row.deleteLater()
        lines = () if profile is None else profile.manual
        self.manual = [ManualRow(number, line) for number, line in enumerate(lines, 1)]
        for row in self.manual:
            row.ticked.connect(self._tick)
            self._manual.addWidget(row)
        for part in (self._manual_title, self._cards[1]):
            part.setVisible(bool(self.manual))

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
        for id_, row in self.rows.items():
            check = judged.get(id_)
            if assessment is None or check is None:
                row.show_waiting(is_checking=is_checking)
                continue
            act = remedy(
                check,
                assessment.case,
                has_profile=self._profile is not None,
                needs_lock=work.needs_lock,
                looked_at=looked_at,
            )
            # What is said of a void result would count for whatever module answers now.
            row.show_judged(check, None if is_void else act, is_void=is_void)
        for item in self.manual:
            state, _at = self._ticks.get(item.number, (None, 0.0))
            item.show_state(state, can_tick=not is_checking)
        self._sort(list(judged.values()))

    def _sort(self, judged: list[Judged]) -> None:
        """Show what did not pass at the top, what is against GO first, and the rest below the fold."""
        failed = [check for check in judged if check.finding.result is not CheckResult.PASS]
        failed.sort(key=lambda check: not check.blocks_go)
        ids = [check.check.id for check in failed]
        passed = [id_ for id_ in self.rows if id_ not in ids]
        for column, names in ((self._failed, ids), (self._passed, passed)):
            for place, id_ in enumerate(names):
                if column.indexOf(self.rows[id_]) != place:
                    column.insertWidget(place, self.rows[id_])
        before: QWidget = self
        for id_ in (*ids, *passed):
            self.setTabOrder(before, self.rows[id_].act)
            before = self.rows[id_].act
        against = sum(check.blocks_go for check in failed)
        titles = [tr("Not met: {names}", names=against)] if against else []
        if len(failed) > against:
            titles.append(tr("Warnings: {count}", count=len(failed) - against))
        self._failed_title.setText(" · ".join(titles))
        self.fold.setText(tr("{count} passed", count=len(passed)))
        for part in (self._failed_title, self._cards[0]):
            part.setVisible(bool(failed))
        self.fold.setVisible(bool(judged))
        self._show_fold()

    def _show_fold(self) -> None:
        is_open = self.fold.isChecked()
        self.fold.setIcon(icon(Icon.CHEVRON_DOWN if is_open else Icon.CHEVRON_RIGHT))
        self._cards[2].setVisible(is_open or self.fold.isHidden())  # before a check they say what is checked

    def _tick(self, number: int, state: bool | None) -> None:
        self._ticks.pop(number, None)
        if state is not None:
            self._ticks[number] = (state, self._ports.clock())
        self.ticked.emit()


def _without_code(profile: Profile | None) -> Profile | None:
    return None if profile is None else profile._replace(approved_fingerprint=None)
