"""The list of checks: what did not pass with the button that mends it, the manual checks, then what passed, folded."""

from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QFrame, QGridLayout, QLabel, QToolButton, QWidget

from app.limits.limits import SETTING_BOUNDS
from app.preflight.checks import CHECKS, RESULT_WORDS, Case, Check, CheckResult, Person, RecordsWord
from app.preflight.verdict import MANUAL_WORDS, VALID_FOR_S, Judged, Standing
from app.settings.profiles import NO_PROFILE, ManualLine, Profile
from app.settings.values import DEFAULTS
from app.text.i18n import tr
from app.text.messages import clean
from protocol.translatable import marked
from ui.core.turns import Turns
from ui.pages.preflight.verdict import can_check, can_enable
from ui.services.context import Services
from ui.style.icons import Icon, StateStyle, icon
from ui.style.theme import IconSize, Meaning, Size, Space, font
from ui.widgets.controls import IconLabel, ScrollArea, in_column, in_row, named, set_role, text_label
from ui.widgets.step_button import StepButton

if TYPE_CHECKING:
    from ui.pages.preflight.page import PreflightPage

_PASSED, _FAILED = StateStyle(Icon.CHECK, Meaning.GOOD), StateStyle(Icon.CROSS, Meaning.DANGER)
_UNKNOWN = StateStyle(Icon.UNKNOWN, Meaning.UNKNOWN)
_STYLES: Final = {
    CheckResult.PASS: _PASSED,
    CheckResult.FAIL: _FAILED,
    CheckResult.WARN: StateStyle(Icon.WARNING, Meaning.ATTENTION),
    CheckResult.UNKNOWN: _UNKNOWN,
}
_MANUAL_STYLES: Final = {True: _PASSED, False: _FAILED, None: _UNKNOWN}
_SETTING_KEYS: Final = {bound.check: key for key, bound in SETTING_BOUNDS.items()}


class Remedy(NamedTuple):
    """A remedy for a check that did not pass: the words of its button, English, marked; `act` does it, here or on the
    page that has the control for it."""

    words: str
    act: Callable[["PreflightPage"], object]
    is_enabling: bool = False


def remedy(judged: Judged, case: Case, looked_at: Counter[bytes]) -> Remedy | None:
    """Return what mends a row with one click; None where only hands can. `looked_at` are the trigger records that a
    person had before them; only those can be called reviewed."""
    id_, is_known = judged.check.id, judged.finding.result is not CheckResult.UNKNOWN

    def said(words: str, person: Person) -> Remedy:
        """Check again with what a person says by pressing it."""
        return Remedy(words, lambda page: page.check(person))

    if id_ in ("attitude_trigger", "freefall_trigger"):
        return Remedy(marked("Enable now"), lambda page: page.check(is_enabling=True), is_enabling=True)
    if id_ == "trigger_records" and judged.blocks_go and (word := judged.finding.word) is not None:
        history = case.evidence.history
        raws = Counter[bytes]() if history is None else Counter(record.raw for record in history.all)
        if word is RecordsWord.REVIEWED and raws - case.past.reviewed - looked_at:
            words = marked("Look at the records")
            return Remedy(words, lambda page: page.lead_to("triggers", page.exchange.review_wanted.emit))
        return said(word.value, Person(are_records_reviewed=True))
    if id_ == "boot_count" and judged.blocks_go and is_known:
        return said(marked("It is this module"), Person(is_same_module=True))
    if id_ == "fingerprint" and is_known:
        return Remedy(marked("Approve these settings"), lambda page: page.approve())
    if (key := _SETTING_KEYS.get(id_)) is not None and judged.blocks_go and is_known:
        words, wanted = marked("Write the profile's value"), case.profile.settings.get(key)
        if wanted is None:
            words, wanted = marked("Write the default"), DEFAULTS.get(key)
        if wanted is not None:
            # It is written in Settings, which asks what it always asks.
            values = {key: wanted}
            return Remedy(words, lambda page: page.lead_to("settings", lambda: page.exchange.used.emit(values)))
    if id_ in ("light", "light_threshold") and is_known:
        return Remedy(marked("Measure"), lambda page: page.lead_to("settings", page.exchange.measured.emit))
    return None


class _Row(QFrame):
    """State, title and two columns, which stretch in the same way in every row; below them a line of its own."""

    def __init__(self, name: str, title: str, measured: str, limit: str) -> None:
        super().__init__()
        named(self, name, "marked-row")
        self.mark = IconLabel(f"{name}_mark", IconSize.STATE, keeps_place=True)
        self.word = named(QLabel(), f"{name}_result", "small")
        # The columns of all rows begin at the same place.
        words = [tr(word) for word in (*RESULT_WORDS.values(), *MANUAL_WORDS.values())]
        self.word.setMinimumWidth(max(map(QFontMetrics(font(Size.SMALL, is_bold=True)).horizontalAdvance, words)))
        self.title = text_label(f"{name}_title", "strong", title)
        self.measured = text_label(f"{name}_measured", text=measured)
        self.limit = text_label(f"{name}_limit", "muted", limit)
        self.grid = QGridLayout(self)
        self.grid.setContentsMargins(Space.S, Space.XS, Space.M, Space.XS)
        self.grid.setHorizontalSpacing(Space.S)
        self.grid.setVerticalSpacing(0)
        parts = ((self.mark, 0), (self.word, 0), (self.title, 4), (self.measured, 3), (self.limit, 4))
        for column, (part, share) in enumerate(parts):
            self.grid.addWidget(part, 0, column)
            self.grid.setColumnStretch(column, share)

    def show_style(self, style: StateStyle, word: str, *, is_failed: bool = False, is_muted: bool = False) -> None:
        self.mark.show_icon(style.icon, style.meaning, is_muted=is_muted)
        self.word.setText(word)
        loud = {Meaning.DANGER: "danger", Meaning.ATTENTION: "attention"}
        set_role(self.word, "small" if is_muted or style.meaning is None else loud.get(style.meaning, "small"))
        set_role(self, "marked-row-failed" if is_failed else "marked-row")

    def say(self, state: str, reason: str = "") -> None:
        """For screen readers."""
        parts = (self.title.text(), state, self.measured.text(), self.limit.text())
        self.setAccessibleName(", ".join(filter(None, parts)))
        self.setAccessibleDescription(reason)
        self.setToolTip(reason)


class CheckRow(_Row):
    """A check: before it is done what is checked and why, then what came of it. Made again for each result, so that its
    button, a step, is dead for a moment: rows move, and what comes to lie under the pointer was not chosen."""

    def __init__(
        self, check: Check, judged: Judged | None = None, remedy: Remedy | None = None, *, is_void: bool = False
    ) -> None:
        found = ("", "") if judged is None else (judged.finding.shown.translated(), judged.finding.limit.translated())
        super().__init__(f"{'planned' if judged is None else 'check'}_{check.id}", tr(check.title), *found)
        self.remedy = remedy
        reason, state, is_explained = tr(check.why), tr(Standing.NOT_CHECKED.value), True
        if judged is None:
            self.show_style(StateStyle(Icon.UNKNOWN, None), "", is_muted=True)
        else:
            result = judged.finding.result
            is_explained = result is not CheckResult.PASS
            words = [tr(RESULT_WORDS[result]), *([tr("void")] if is_void else [])]
            state = " · ".join(words)
            is_failed = judged.blocks_go and not is_void
            self.show_style(_STYLES[result], "\n".join(words), is_failed=is_failed, is_muted=is_void)
            set_role(self.measured, "muted" if is_void else "strong" if is_explained else "")
            if is_explained:
                reason = f"{reason} → {judged.do.translated()}"
        self.reason = text_label(f"{self.objectName()}_why", "small", reason)
        below = in_row((self.reason, 1), spacing=Space.M)
        self.grid.addLayout(below, 1, 2, 1, 3)
        self.reason.setVisible(is_explained)
        self.act: StepButton | None = None
        if remedy is not None:
            says = f"{tr(remedy.words)}: {self.title.text()}"
            self.act = named(StepButton(tr(remedy.words)), f"{self.objectName()}_act", says=says)
            below.addWidget(self.act)
        self.say(state, reason)


class ManualRow(_Row):
    """`state`: whether it is OK, or None where it is skipped. `ticked`: by a person, when is `at`."""

    ticked = Signal()

    def __init__(self, number: int, line: ManualLine, clock: Callable[[], float]) -> None:
        required = tr("required") if line.is_required else tr("optional")
        super().__init__(f"manual_{number}", clean(line.text), "", required)
        self.number, self.line, self._clock = number, line, clock
        self.state: bool | None = None
        self.at = 0.0
        self.done = named(QToolButton(), f"{self.objectName()}_done")
        self.bad = named(QToolButton(), f"{self.objectName()}_bad")
        for button, text, state in ((self.done, tr("OK"), True), (self.bad, tr("Not OK"), False)):
            button.setText(text)
            button.setCheckable(True)
            button.clicked.connect(lambda is_on, state=state: self._tick(state if is_on else None))
        self.grid.addLayout(in_row(self.done, self.bad, spacing=Space.S), 0, 5)
        self.show_state(None)

    def show_state(self, state: bool | None) -> None:
        self.state = state
        self.show_style(_MANUAL_STYLES[state], tr(MANUAL_WORDS[state]), is_failed=state is False)
        self.done.setChecked(state is True)
        self.bad.setChecked(state is False)
        self.say(self.word.text())

    def _tick(self, state: bool | None) -> None:
        self.at = self._clock()
        self.show_state(state)
        self.ticked.emit()


class _Card(QFrame):
    """Rows below a title, if there is one; without rows neither is shown."""

    def __init__(self, name: str, title: QWidget | None = None) -> None:
        super().__init__()
        named(self, f"preflight_{name}_checks", "card")
        self.title, self._column = title, in_column(of=self, spacing=0, margins=1)

    def fill(self, rows: Sequence[_Row]) -> None:
        """Put rows in place of the former ones."""
        for former in self.findChildren(_Row):
            former.setParent(None)
            former.deleteLater()
        for row in rows:
            self.add(row)
        for part in (self.title, self):
            if part is not None:
                part.setVisible(bool(rows))

    def add(self, row: _Row) -> None:
        self._column.addWidget(row)


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
        # What is checked and why; shown while there is no result. They are made once, as they take long.
        self._planned: dict[str, CheckRow] = {}
        # The rows in sight; those that passed are made when the fold is opened.
        self.rows: dict[str, CheckRow] = {}
        self.manual: list[ManualRow] = []
        self._passed_checks: list[Judged] = []
        self._unfolding = Turns(self)
        # What the rows were last made for.
        self._shown: tuple[object, ...] = ()
        self._failed_title = named(QLabel(), "preflight_failed_title", "caption")
        self.fold = named(QToolButton(), "preflight_fold", "quiet")
        self.fold.setCheckable(True)
        self.fold.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.fold.toggled.connect(self._show_fold)
        self._failed, self._passed = _Card("failed", self._failed_title), _Card("passed")
        self._plan = _Card("planned")
        manual_title = named(QLabel(tr("Manual checks")), "preflight_manual_title", "caption")
        self._manual = _Card("manual", manual_title)
        content = named(QWidget(), "preflight_content")
        fold = (self.fold, Qt.AlignmentFlag.AlignLeft)
        parts = (self._failed_title, self._failed, manual_title, self._manual, self._plan, fold, self._passed)
        self.column = in_column(*parts, 1, of=content, spacing=Space.XS, margins=(Space.M, 0, Space.M, Space.S))
        self._manual.fill(())
        self.setWidget(content)

    def answered(self) -> Profile:
        answers = {row.number: row.state for row in self.manual if row.state is not None}
        return NO_PROFILE if self._profile is None else self._profile.answered(answers)

    def use_profile(self, profile: Profile | None) -> None:
        """Show the items of another profile, none of them ticked; with another approved code it is the same one."""
        former, self._profile = self._profile, profile
        if former and profile and former == profile._replace(approved_fingerprint=former.approved_fingerprint):
            return
        lines = profile.manual if profile else ()
        self.manual = [ManualRow(number, line, self._ports.clock) for number, line in enumerate(lines, 1)]
        for row in self.manual:
            row.ticked.connect(self.ticked)
        self._manual.fill(self.manual)

    def clear_ticks(self) -> None:
        for row in self.manual:
            row.show_state(None)

    def clear_old_ticks(self) -> None:
        """Remove ticks that were made for an earlier flight."""
        for row in self.manual:
            if row.state is not None and self._ports.clock() - row.at > VALID_FOR_S:
                row.show_state(None)

    def show_check(self) -> None:
        """Show the results, unless they are shown already: signals come many times during a check."""
        module = self._ports.module
        standing, assessment, _void = module.check_state
        shown = (assessment, standing, module.looked_at.copy())
        if shown != self._shown:
            self._shown = shown
            self._place([] if assessment is None else assessment.checks)
            self._plan.setVisible(assessment is None)
            if assessment is None:
                self._show_plan(standing)
        self._manual.setEnabled(standing is not Standing.CHECKING)

    def _show_plan(self, standing: Standing) -> None:
        if not self._planned:
            self._planned = {check.id: CheckRow(check) for check in CHECKS}
            self._plan.fill(tuple(self._planned.values()))
        self.rows = dict(self._planned)
        for row in self.rows.values():
            row.say(tr(standing.value), row.toolTip())  # for the eye the verdict says it

    def _row(self, judged: Judged) -> CheckRow:
        module, mends = self._ports.module, None
        standing, assessment, _void = module.check_state
        is_void, is_passed = standing is Standing.VOID, judged.finding.result is CheckResult.PASS
        # What is said of a void result would count for whatever module answers now.
        if assessment is not None and not is_void and not is_passed:
            mends = remedy(judged, assessment.case, module.looked_at)
        return CheckRow(judged.check, judged, mends, is_void=is_void)

    def enable_acts(self) -> None:
        for row in self.rows.values():
            if row.act is not None and row.remedy is not None:
                row.act.setEnabled((can_enable if row.remedy.is_enabling else can_check)(self._ports))

    def _place(self, judged: Sequence[Judged]) -> None:
        """Show what did not pass at the top, what is against GO first, and the rest below the fold."""
        failed = [check for check in judged if check.finding.result is not CheckResult.PASS]
        failed.sort(key=lambda check: not check.blocks_go)
        against = sum(check.blocks_go for check in failed)
        titles = [tr("Not met: {names}", names=against)] if against else []
        if len(failed) > against:
            titles.append(tr("Warnings: {count}", count=len(failed) - against))
        self._failed_title.setText(" · ".join(titles))
        self.rows = {check.check.id: self._row(check) for check in failed}
        self._failed.fill(tuple(self.rows.values()))
        before: QWidget = self
        for row in self.rows.values():
            if row.act is not None:
                row.act.chosen.connect(lambda wanted=row.remedy: self.mend_wanted.emit(wanted))
                self.setTabOrder(before, row.act)
                before = row.act
        self._passed_checks = [check for check in judged if check not in failed]
        self.fold.setText(tr("{count} passed", count=len(self._passed_checks)))
        self.fold.setVisible(bool(judged))
        self._show_fold()

    def _show_fold(self) -> None:
        is_open = self.fold.isChecked()
        self.fold.setIcon(icon(Icon.CHEVRON_DOWN if is_open else Icon.CHEVRON_RIGHT))
        for check in self._passed_checks:
            self.rows.pop(check.check.id, None)
        self._passed.fill(())
        self._passed.setVisible(is_open and bool(self._passed_checks))
        self._unfolding.take(partial(self._add_passed, check) for check in self._passed_checks if is_open)

    def _add_passed(self, judged: Judged) -> None:
        row = self.rows[judged.check.id] = self._row(judged)
        self._passed.add(row)
