"""The guided tests: the list at the left, the chosen one at the right, step by step.

Leaving them during a test (another view or page, a closed or minimised window, a program error) ends the test, and
locks the module if the test may have made it active.
"""

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QEvent, QObject, QSignalBlocker, Qt, QTimer
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QApplication, QCheckBox, QFrame, QListWidget, QWidget

from app.guided.guided_tests import GUIDED_TESTS
from app.guided.results import TITLES, VERDICT_WORDS, GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue
from app.procedures.lock import SENTENCES
from app.safety.journal import Act, Outcome
from app.safety.last_known import Activation
from app.system.clock import DAY, local_time
from app.text.i18n import tr
from app.text.messages import capitalised, message
from protocol.translatable import marked
from ui.acts.act_row import ActRow
from ui.forms.tables import RowsTable, TableColumn
from ui.services.context import Services
from ui.session.guided import FAILED, Stage
from ui.session.shown_module import ShownModule
from ui.style.icons import MEANING_ICONS, icon, set_icon_size
from ui.style.theme import IconSize, Meaning, RowHeight, Space, is_text_large
from ui.widgets.controls import in_column, in_row, named, scroll_area, set_role, text_label
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.notices import Notice
from ui.widgets.step_button import StepButton
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 100
_MEANINGS: Final = {
    GuidedVerdict.PASSED: Meaning.GOOD,
    GuidedVerdict.FAILED: Meaning.DANGER,
    GuidedVerdict.UNCLEAR: Meaning.ATTENTION,
}
# What a test watches: its caption, its key, how it is written, and the key of its limit.
_WATCHED: Final = {
    GuidedKind.TILT: (marked("Tilt"), "tilt_deg", "{:.0f}°", "attitude_threshold_deg"),
    GuidedKind.FREE_FALL: (marked("Acceleration"), "acceleration_g", "{:.1f} g", "freefall_acceleration_g"),
    GuidedKind.BAY: (marked("Light"), "light_v", "{:.1f} V", "light_threshold_v"),
}
_COLUMNS: Final[tuple[TableColumn[MeasuredValue], ...]] = (
    TableColumn(marked("Quantity"), lambda row: row.name.translated()),
    TableColumn(marked("Measured"), lambda row: row.shown.translated(), stretches=True),
    TableColumn(marked("Tolerance"), lambda row: row.tolerance.translated(), stretches=True, is_spare=True),
    TableColumn(
        marked("Result"),
        lambda row: tr(VERDICT_WORDS[row.verdict]),
        picture=lambda row: icon(MEANING_ICONS[_MEANINGS[row.verdict]], _MEANINGS[row.verdict]),
        ink=lambda row: _MEANINGS[row.verdict],
    ),
)


class GuidedPanel(QWidget):
    """The panel of the guided tests of the module shown. `commit_person` takes what is typed in the page's form, and
    gives who tests."""

    def __init__(self, services: Services, commit_person: Callable[[], str]) -> None:
        super().__init__()
        self.setObjectName("guided")
        self._ports, self._commit_person = services.ports, commit_person
        self.module = services.ports.module
        self.work = self.module.guided
        self._watched: QWidget | None = None
        self.list = named(QListWidget(), "guided_list", says=tr("Guided tests"))
        self.list.setWordWrap(True)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.addItems([tr(TITLES[test.kind]) for test in GUIDED_TESTS])
        set_icon_size(self.list, IconSize.STATE)
        self.title = text_label("guided_title", "title")
        self.safety, self.notice_bar = named(NoticeBar(), "guided_safety"), named(NoticeBar(), "guided_said")
        self.made_safe = named(QCheckBox(), "guided_made_safe")
        self.activate = ActRow(services, Act.ACTIVATE, place="guided")
        self.live, self.steps = text_label("guided_live", "heading"), text_label("guided_steps")
        self.verdict, self.advice = text_label("guided_verdict", "heading"), text_label("guided_advice")
        self.table = RowsTable(
            "guided_table",
            tr("Measured values"),
            _COLUMNS,
            identify=lambda row: row.name,
            row_px=RowHeight.LIST,
            is_single=True,
        )
        self.cancel = named(StepButton(tr("Cancel"), is_safe=True), "guided_cancel")
        self.cancel.setToolTip(tr("Locks an activated module"))
        self.primary = named(StepButton(tr("Start"), is_safe=True), "guided_run", "primary")
        self._lay_out()
        self.list.currentRowChanged.connect(lambda row: self.work.choose(GUIDED_TESTS[row].kind))
        self.cancel.chosen.connect(self._cancel)
        self.primary.chosen.connect(self.go_on)
        services.ports.failed.connect(lambda: self.work.cancel(FAILED))
        # By then it is the test of another module.
        self.made_safe.toggled.connect(lambda is_safe: self.work.state_safe(is_safe))  # noqa: PLW0108
        self.activate.begun.connect(lambda: self.work.act_begun())  # noqa: PLW0108
        self.activate.ended.connect(lambda performed: self.work.act_ended(performed))  # noqa: PLW0108
        self.work.changed.connect(self._on_work)
        VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS, tick=self.tick, hidden=self._cancel)

    def show_module(self, module: ShownModule) -> None:
        kind = self.work.kind
        self.work.cancel()
        self.work.changed.disconnect(self._on_work)
        self.module, self.work = module, module.guided
        if self.work.outcome is None:
            self.work.choose(kind)  # who was interrupted is not led to the test that fires
        self.work.changed.connect(self._on_work)
        self.work.load_last()
        self._on_work()

    # Display

    def refresh(self) -> None:
        self._show_list()
        self._show_stage()
        self._show_outcome()
        self.tick()

    def tick(self) -> None:
        """Update what changes by itself."""
        work = self.work
        if work.is_running:
            self.live.setText(self._live_text())
        if work.stage is Stage.CONFIRMING:
            self.activate.refresh()
        self.notice_bar.show_notices(self._notices())
        is_asked_again = work.stage is Stage.DONE and bool(work.test.statement) and not work.owes_lock
        self.primary.setEnabled(work.can_start or bool(work.confirm_words) or is_asked_again)

    def _live_text(self) -> str:
        """The current value beside its limit; of the link how many requests were lost."""
        work, module = self.work, self.module
        if work.kind not in _WATCHED:
            values = {} if work.report is None else dict(work.report.values)
            return f"{tr('lost')}: {values['lost']} / {values['asked']}" if "asked" in values else "—"
        caption, key, written, limit_key = _WATCHED[work.kind]
        known = (module.view.fresh(one, module.now_s) for one in (key, limit_key))
        value, limit = ("—" if one is None else written.format(float(one)) for one in known)
        parts = [f"{tr(caption)}: {value}", tr("limit {limit}", limit=limit)]
        has_fired = module.view.fresh("triggered", module.now_s) if work.kind is GuidedKind.TILT else None
        if has_fired is not None:
            not_now = tr("may have fired") if module.may_have_fired else tr("not triggered")
            parts.append(tr("TRIGGERED") if has_fired else not_now)
        return " · ".join(parts)

    def _show_list(self) -> None:
        for row, test in enumerate(GUIDED_TESTS):
            item, last = self.list.item(row), self.work.last.get(test.kind)
            said, meaning = tr("not tested"), Meaning.UNKNOWN
            if last is not None:
                said = f"{tr(VERDICT_WORDS[last.verdict])} {local_time(last.at, DAY)}, {last.who or '—'}"
                meaning = _MEANINGS[last.verdict]
            text = f"{tr(TITLES[test.kind])}\n{said}"
            item.setText(text)
            item.setToolTip(text)
            item.setIcon(icon(MEANING_ICONS[meaning], meaning))
        with QSignalBlocker(self.list):
            self.list.setCurrentRow([test.kind for test in GUIDED_TESTS].index(self.work.kind))
        self.list.setEnabled(not self.work.is_running)

    def _show_stage(self) -> None:
        work, test, stage = self.work, self.work.test, self.work.stage
        instruction = tr("Asking the module…") if work.is_running else ""
        if stage is Stage.CONFIRMING:
            instruction = test.steps[work.step].translated()
        elif work.report is not None:
            instruction = message(work.report.doing, **dict(work.report.values)).translated()
        self.title.setText(instruction or tr(TITLES[test.kind]))
        lines = []
        for number, step in enumerate(test.steps):
            mark = "▸" if work.is_running and number == work.step else f"{number + 1}."
            lines.append(f"{'✓' if number < work.step else mark} {step.translated()}")
        self.steps.setText("\n".join(lines))
        self.steps.setVisible(stage is not Stage.DONE)
        meaning = Meaning.DANGER if test.is_active else Meaning.INFORMATION
        self.safety.show_notices([Notice(meaning, tr(test.safety))] if stage is Stage.READY else [])
        self.made_safe.setVisible(stage is Stage.READY and bool(test.statement))
        self.made_safe.setText(tr(test.statement) if test.statement else "")
        with QSignalBlocker(self.made_safe):
            self.made_safe.setChecked(work.is_stated_safe)
        is_asked = stage is Stage.CONFIRMING
        if is_asked and self._act_corner.isHidden():
            QTimer.singleShot(0, self, lambda: self._scroll.ensureWidgetVisible(self._act_corner))
        self._act_corner.setVisible(is_asked)
        self.live.setVisible(work.is_running and not is_asked)
        words = {Stage.READY: marked("Start"), Stage.DONE: marked("Test again")}.get(stage, marked("Next"))
        words = work.confirm_words or words
        self.primary.setText(tr(words))
        self.cancel.setEnabled(work.is_running)
        if self.isVisible() and self.primary.isEnabled() and QApplication.focusWidget() is None:
            self.primary.setFocus()

    def _show_outcome(self) -> None:
        outcome = self.work.outcome
        measured, advice, role = tuple[MeasuredValue, ...](), "", "title"
        if isinstance(outcome, GuidedResult):
            role, measured = f"verdict-of-{outcome.verdict.value}", outcome.measured
            self.verdict.setText(capitalised(tr(VERDICT_WORDS[outcome.verdict])))
            advice = "" if outcome.advice is None else outcome.advice.translated()
        elif outcome is not None:
            self.verdict.setText(outcome.message.translated())
        set_role(self.verdict, role)
        self.advice.setText(advice)
        self.table.show_rows(measured)
        rows_px = self.table.verticalHeader().defaultSectionSize() * (len(measured) + 1)
        self.table.setFixedHeight(rows_px + self.table.horizontalHeader().sizeHint().height())
        self.verdict.setVisible(self.work.stage is Stage.DONE)
        self.advice.setVisible(bool(advice))
        self.table.setVisible(bool(measured))

    def _notices(self) -> list[Notice]:
        work, lock = self.work, self._ports.current.lock
        locking = lock.notice()
        if locking is not None:
            return [locking]
        if self.module.activation.state is Activation.ACTIVE and not work.is_running:
            return [Notice(Meaning.DANGER, tr("The module is ACTIVE: lock it first."))]
        if work.stage is Stage.DONE and lock.is_reported and work.test.is_active:
            # No success beside a test that was cancelled or has failed.
            return [Notice(Meaning.INFORMATION, tr(SENTENCES[Outcome.CONFIRMED]))]
        text = work.trouble
        if text is None and work.stage is Stage.DONE and isinstance(work.outcome, GuidedResult):
            if not work.tested_as:
                text = tr("Without a name the result counts for no check.")
            elif work.tested_as != self.module.name:
                text = tr("The result is that of {module}.", module=work.tested_as)
        return [] if text is None else [Notice(Meaning.ATTENTION, text)]

    # What a person does

    def _cancel(self) -> None:
        self.work.cancel()

    def go_on(self) -> None:
        """Do what the main button says: start, confirm a step, or test again."""
        if self.work.stage is Stage.DONE and self.work.test.statement:
            self.work.choose(self.work.kind)  # the statement has to be made again
        elif self.work.confirm_words:
            self.work.confirm()
        else:
            self.work.start(self._commit_person())

    # What happens

    def _on_work(self) -> None:
        if self.isVisible():
            self.refresh()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self._watched is not self.window():
            self._watched = self.window()
            self._watched.installEventFilter(self)
        self.work.load_last()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        is_minimised = event.type() == QEvent.Type.WindowStateChange and self.window().isMinimized()
        if watched is self._watched and (event.type() == QEvent.Type.Close or is_minimised):
            self._cancel()
        return False

    def _lay_out(self) -> None:
        self._act_corner = named(QFrame(), "guided_act", "danger-corner")
        in_column(self.activate, of=self._act_corner, margins=2)
        set_role(self.activate, "")  # no line below it
        result = in_column(self.verdict, self.advice, self.table, spacing=Space.S)
        content = named(QWidget(), "guided_content")
        parts = (self.safety, self.made_safe, self._act_corner, self.live, self.steps, result)
        # Beside large text the notice scrolls with the rest, so that the main button stays in sight.
        at_top, below = ((self.notice_bar,), ()) if is_text_large() else ((), (self.notice_bar,))
        in_column(*at_top, *parts, 1, of=content, spacing=Space.M, margins=0)
        self._scroll = scroll_area(content, "guided_scroll", tr("Guided tests"), is_vertical=True)
        foot = in_row(1, self.cancel, self.primary, spacing=Space.S)
        pane = in_column(self.title, (self._scroll, 1), *below, foot, spacing=Space.S)
        in_row((self.list, 2), (pane, 5), of=self, spacing=Space.M, margins=(Space.M, 0, Space.M, Space.S))
