"""The deploy panel: choose, arm, hold; and the guard that disarms it.

Fifty times a second it checks for what disarms: an open condition, the end of the conversation, another window or
field, an error anywhere in the window, an armed control that is not visible. Cancel has the focus at every
step, and each control has its own place at the bottom of the page.
"""

import sys
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from types import TracebackType
from typing import Final

from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QFontMetrics, QHideEvent, QKeyEvent
from PySide6.QtWidgets import QFrame, QGridLayout, QLabel, QProgressBar, QStackedLayout, QWidget

from app.engine.procedure import Job
from app.procedures.act import Performed, perform, rehearse
from app.safety.journal import EFFECTS, REQUESTS, TITLES, Act
from app.safety.permit import Interlock, Permit
from app.safety.ritual import ARMED_FOR_S, HOLD_S, Input, Ritual, Stage
from app.text.i18n import tr
from app.text.messages import join_sentences, labelled
from protocol.translatable import marked
from ui.acts.act_row import ASKING, keep_interrupted, not_begun, open_conditions, outcome_notice
from ui.acts.confirm import HoldButton
from ui.services.context import Services
from ui.session.shown_module import RunningJob, ShownModule
from ui.style.appearance import announce
from ui.style.theme import Meaning, Size, Space, font, is_text_large
from ui.widgets.controls import (
    ElidedLabel,
    control,
    in_column,
    in_row,
    named,
    retain_size,
    set_role,
    stacked,
    text_label,
)
from ui.widgets.gestures import application, gestures
from ui.widgets.notice_bar import Notice, NoticeBar
from ui.widgets.step_button import StepButton, bring_into_sight, is_in_sight, leave_focus

_Hook = Callable[[type[BaseException], BaseException, TracebackType | None], object]


class RitualGuard(QObject):
    """Watches from `begin` to `end`. `broken` carries the reason; its receivers disarm."""

    broken = Signal(object)

    def __init__(self, widget: QWidget) -> None:
        super().__init__(widget)
        self._widget = widget
        self._window: QWidget | None = None
        self._hook_before: _Hook | None = None
        application().focusChanged.connect(self._on_focus_changed)

    @property
    def is_watching(self) -> bool:
        return self._window is not None

    def begin(self) -> None:
        if not self.is_watching:
            self._hook_before = sys.excepthook
            sys.excepthook = self._on_fault
            self._window = self._widget.window()
            self._window.installEventFilter(self)

    def end(self) -> None:
        if self._window is not None:
            self._window.removeEventFilter(self)
            self._window = None
            # A hook that was installed over this one stays; this one then only forwards.
            if self._hook_before is not None and sys.excepthook == self._on_fault:
                sys.excepthook = self._hook_before

    def _on_fault(self, kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        self._break(Input.FAILED)
        if self._hook_before is not None:
            self._hook_before(kind, error, trace)

    def _on_focus_changed(self, _old: QWidget | None, now: QWidget | None) -> None:
        if now is None:
            self._break(Input.WINDOW_LEFT)
        elif now is not self._widget and not self._widget.isAncestorOf(now):
            self._break(Input.FOCUS_LOST)

    def _break(self, why: Input) -> None:
        if self.is_watching:
            self.broken.emit(why)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if event.type() in (QEvent.Type.WindowDeactivate, QEvent.Type.Hide, QEvent.Type.Close):
            self._break(Input.WINDOW_LEFT)
        return False


TICK_MS: Final = 20
_STEPS: Final = (("choose", marked("Choose")), ("arm", marked("Arm")), ("hold", marked("Hold for 2 s")))
_ENDED: Final = {
    Input.CANCEL: marked("cancelled"),
    Input.RAN_OUT: marked("time is up"),
    Input.RELEASE: marked("released too early"),
    Input.PRESS: marked("another press"),
    Input.HOLD_BROKEN: marked("window was busy"),
    Input.OUT_OF_SIGHT: marked("buttons not in sight"),
    Input.FOCUS_LOST: marked("focus lost"),
    Input.WINDOW_LEFT: marked("window left"),
    Input.INTERRUPTED: marked("interrupted"),
    Input.CONDITION_OPENED: marked("a condition is not met"),
    Input.FAILED: marked("program error"),
}


class RitualWidget(QFrame):
    """`refresh` updates the open conditions."""

    def __init__(self, services: Services) -> None:
        super().__init__()
        named(self, "ritual", "danger-corner")
        self.ritual = Ritual()
        self._services, self._ports = services, services.ports
        # Why it was disarmed: it stays when the next conversation begins, since the person held the button.
        self._disarmed: Notice | None = None
        # The number of the one in which it was chosen.
        self._conversation = 0
        self._title = named(ElidedLabel(), "ritual_title", "strong")
        self._effect = text_label("ritual_effect", "small")
        self.conditions = text_label("ritual_conditions", "attention")
        # Stacked, so that a notice never changes the height of the panel.
        self._reasons, self._head = QStackedLayout(), QStackedLayout()
        self._words = named(QWidget(), "ritual_words")
        self.step = text_label("ritual_step", "strong")
        self.step.setWordWrap(False)
        self.marks = [
            named(QLabel(tr("Step {number}: {name}", number=number, name=tr(title))), f"ritual_step_{name}")
            for number, (name, title) in enumerate(_STEPS, 1)
        ]
        self.countdown = control(QProgressBar(), "ritual_countdown", says=tr("Disarms in"))
        self.countdown.setTextVisible(False)
        self.countdown.setRange(0, round(ARMED_FOR_S * 1000))
        self.choose = control(
            StepButton(tr("Deploy…")),
            "ritual_choose",
            role="danger",
            slot=partial(self._choose, is_rehearsal=False),
            tip=tr("Arm, then hold for two seconds. Letting go, Esc or leaving the page sends nothing."),
        )
        self.rehearse = control(
            StepButton(tr("Rehearse…")),
            "ritual_rehearse",
            tip=tr("Nothing is sent."),
            slot=partial(self._choose, is_rehearsal=True),
        )
        self.arm = named(StepButton(tr("Arm for 10 s")), "ritual_arm", "danger")
        self._hold_texts = (tr("Hold to DEPLOY"), tr("Hold to rehearse"))
        self.hold = control(HoldButton(*self._hold_texts), "ritual_hold", tip=tr("Mouse or space bar"))
        self.cancel = control(
            StepButton(tr("Cancel"), is_safe=True), "ritual_cancel", tip=tr("Nothing is sent."), key="Esc"
        )
        self.notice_bar = named(NoticeBar(), "ritual_said")
        self.arm.chosen.connect(self._arm)
        self.cancel.chosen.connect(partial(self.disarm, Input.CANCEL))
        self.hold.hold_started.connect(self._press)
        self.hold.hold_ended.connect(self._release)
        self._ports.changed.connect(self._watch)
        self._ports.shown.connect(self._on_another_module)
        self._ports.leaving.connect(partial(self.disarm, Input.INTERRUPTED))
        self._ports.chosen.connect(self._forget_disarmed)
        self._guard = RitualGuard(self)
        self._guard.broken.connect(self.disarm)
        self._timer = QTimer(self, interval=TICK_MS, timerType=Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._tick)
        self._lay_out()
        self._show()

    @property
    def is_under_way(self) -> bool:
        return self.ritual.stage in (Stage.CHOSEN, Stage.ARMED, Stage.HOLDING)

    @property
    def _job(self) -> RunningJob:
        """Of the module shown; what came of it is shown on no other."""
        return self._ports.module.job("ritual")

    def refresh(self) -> None:
        self._title.setText(self._heading())
        refusals = open_conditions(self._services, Act.DEPLOY)
        self.conditions.setText(join_sentences(refusal.sentence for refusal in refusals))
        is_rehearsal = self.is_under_way and self.ritual.is_rehearsal
        self._effect.setText(tr("Nothing is sent.") if is_rehearsal else tr(EFFECTS[Act.DEPLOY]))
        self._reasons.setCurrentWidget(self.conditions if refusals and not is_rehearsal else self._effect)
        is_free = not self.is_under_way and not self._job.is_running
        # An old status does not disable the button: the engine asks for a new one before it decides.
        blocking = [refusal for refusal in refusals if refusal.condition is not Interlock.FRESH_STATUS]
        self.choose.setEnabled(is_free and not blocking)
        self.rehearse.setEnabled(is_free)
        self.arm.setEnabled(self.ritual.stage is Stage.CHOSEN and (self.ritual.is_rehearsal or not refusals))
        notice = self._job.notice(ASKING, can_cancel=False) or self._disarmed
        self.notice_bar.show_notice(notice)
        self._head.setCurrentWidget(self._words if notice is None else self.notice_bar)

    def disarm(self, why: Input) -> None:
        """Disarm; nothing is sent."""
        if self.is_under_way:
            self.ritual.disarm(why)
            self._on_stage()

    # The gestures

    def _choose(self, *, is_rehearsal: bool) -> None:
        if not is_in_sight(self):
            bring_into_sight(self)
            if is_in_sight(self):
                return  # it moved under the pointer; where there is no room for all of it, the watch says so
        self._conversation = self._ports.module.number
        self.ritual.choose(self._conversation, is_rehearsal=is_rehearsal)
        self._focus_cancel()
        self._job.dismiss()
        self._disarmed = None
        self._begin_watching()
        self._show()

    def _arm(self) -> None:
        self.ritual.arm(self._ports.clock())
        self._services.armed.act = Act.DEPLOY
        self._focus_cancel()
        self._show()

    def _focus_cancel(self) -> None:
        """Move the focus before the button that has it is hidden: it would go elsewhere and disarm."""
        self.cancel.show()
        self.cancel.setFocus()

    def _press(self) -> None:
        self.ritual.press(self._ports.clock())
        self._on_stage()

    def _release(self) -> None:
        if not self.isVisible():
            self.disarm(Input.WINDOW_LEFT)
        elif self.ritual.stage is Stage.HOLDING:
            self.ritual.release()
            self._on_stage()

    # The watch

    def _begin_watching(self) -> None:
        self._timer.start()
        self._guard.begin()

    def _watch(self) -> None:
        """Check the conversation and the conditions; called at every change and tick."""
        if not self.is_under_way:
            return
        module = self._ports.module
        is_same = module.number == self._conversation and (module.is_going or self._conversation == 0)
        if not is_same:
            self.disarm(Input.INTERRUPTED)
        elif self.ritual.stage is Stage.HOLDING and not self.hold.hasFocus():
            self.disarm(Input.FOCUS_LOST)
        elif not self._is_in_sight():
            self.disarm(Input.OUT_OF_SIGHT)
        elif self.ritual.is_armed and self._services.armed.act is None:
            self.disarm(Input.FAILED)  # disarmed by an error in another thread
        elif self.ritual.is_armed and not self.ritual.is_rehearsal and open_conditions(self._services, Act.DEPLOY):
            self.disarm(Input.CONDITION_OPENED)

    def _on_another_module(self, _module: ShownModule) -> None:
        self.disarm(Input.INTERRUPTED)
        self.ritual.disarm(Input.FINISHED)  # the outcome is shown to nobody
        self._show()

    def _forget_disarmed(self) -> None:
        self._disarmed = None
        self.refresh()

    def _is_in_sight(self) -> bool:
        """Whether the controls of this step are entirely visible."""
        return all(is_in_sight(button) for button in (self.cancel, self.arm, self.hold) if not button.isHidden())

    def _tick(self) -> None:
        try:
            self._watch()
            if gestures().is_release_uncertain:
                return  # known within about 50 ms
            permit = self.ritual.tick(self._ports.clock())
        except BaseException:
            self.disarm(Input.FAILED)
            raise
        if permit is not None:
            self._fire(permit)
        self._on_stage()

    def _on_stage(self) -> None:
        """Show the stage; clean up once it is IDLE or FIRED."""
        if not self.is_under_way and self._guard.is_watching:
            self._timer.stop()
            self._guard.end()
            self._services.armed.act = None
            gestures().ignore_keys_down()
            leave_focus(self)
            why = self.ritual.ended_by
            if self.ritual.stage is Stage.IDLE and why is not None and why in _ENDED:
                self._disarmed = _ended_notice(why)._replace(dismiss=self._forget_disarmed)
                announce(self._disarmed.text)
        self._show()

    # The end of it

    def _fire(self, permit: Permit) -> None:
        if permit.is_rehearsal:
            self.ritual.disarm(Input.FINISHED)
            self._job.set_notice(outcome_notice(rehearse(Act.DEPLOY)))
            return
        module = self._ports.module
        performing = perform(Act.DEPLOY, module.journal, permit=permit, armed=self._services.armed)
        self._job.run(performing, partial(self._end, module))

    def _end(self, module: ShownModule, job: Job[Performed]) -> None:
        self.ritual.disarm(Input.FINISHED)
        done = None if job.error is not None else job.outcome()
        module.job("ritual").set_notice(not_begun() if done is None else outcome_notice(done))
        if done is not None:
            keep_interrupted(module, done)

    def _show(self) -> None:
        ritual, now = self.ritual, self._ports.clock()
        stage = ritual.stage
        for widget, is_shown in (
            (self.cancel, self.is_under_way),
            (self.hold, ritual.is_armed),
            (self.arm, stage is Stage.CHOSEN),
            (self.choose, not self.is_under_way),
            (self.rehearse, not self.is_under_way),
            (self.countdown, ritual.is_armed),
        ):
            widget.setVisible(is_shown)  # also what was never shown: it would appear with its parent
        self.countdown.setValue(round(ritual.armed_left_s(now) * 1000))
        self.hold.show_share(ritual.held_s(now) / HOLD_S)
        self._show_step(now)
        in_earnest, as_rehearsal = self._hold_texts
        self.hold.setText(as_rehearsal if ritual.is_rehearsal else in_earnest)
        self.refresh()

    def _show_step(self, now: float) -> None:
        """Show the three steps and what comes next; a rehearsal has its own frame and title."""
        stage, is_rehearsal = self.ritual.stage, self.is_under_way and self.ritual.is_rehearsal
        set_role(self, "rehearsal" if is_rehearsal else "danger-corner")
        set_role(self.hold, "" if is_rehearsal else "danger")
        set_role(self.arm, "" if is_rehearsal else "danger")
        due = {Stage.CHOSEN: 1, Stage.ARMED: 2, Stage.HOLDING: 2}.get(stage, 0)
        for number, mark in enumerate(self.marks):
            is_now = number == due and self.is_under_way
            state = tr("done") if number < due else tr("now") if is_now else ""
            spoken = ", ".join(filter(None, (mark.text(), state)))
            if mark.accessibleName() != spoken:
                mark.setAccessibleName(spoken)
            set_role(mark, ("strong" if is_rehearsal else "danger") if is_now else "caption")
        frame = REQUESTS[Act.DEPLOY].encode().hex(" ").upper()
        match stage:
            case Stage.CHOSEN:
                self.step.setText(tr("It would send {frame}.", frame=frame))
            case Stage.ARMED | Stage.HOLDING:
                self.step.setText(tr("ARMED: {seconds:.0f} s.", seconds=self.ritual.armed_left_s(now)))
            case _:
                self.step.setText("")

    def _heading(self) -> str:
        """With module and port, if connected."""
        is_rehearsal = self.is_under_way and self.ritual.is_rehearsal
        act, target = tr("REHEARSAL") if is_rehearsal else tr(TITLES[Act.DEPLOY]), self._ports.current.target
        if target is None or not self._ports.current.is_open:
            return act
        port = target.device.removeprefix("/dev/").partition("?")[0]
        name = self._ports.module.name
        if not name:
            return labelled(act, port)
        return tr("{act}: {module} on {port}", act=act, module=name, port=port)

    # Qt

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and self.is_under_way:
            self.disarm(Input.CANCEL)
        else:
            super().keyPressEvent(event)

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self.disarm(Input.WINDOW_LEFT)

    def _lay_out(self) -> None:
        for part in (self._effect, self.conditions, self._words, self.notice_bar):
            retain_size(part)  # as high for any of them
        stacked(self._reasons, self._effect, self.conditions)
        stacked(self._head, self._words, self.notice_bar)
        reasons = in_row((self._reasons, 1), self.step, self.countdown, spacing=Space.M)
        if is_text_large():
            in_column(self._title, reasons, of=self._words, spacing=0, margins=0)
            # Room for a reason of two lines: the panel never grows while its buttons are used.
            small_px = QFontMetrics(font(Size.SMALL)).lineSpacing()
            self._words.setMinimumHeight(QFontMetrics(font(is_bold=True)).lineSpacing() + 2 * small_px)
        else:
            in_row(self._title, (reasons, 1), of=self._words, spacing=Space.M, margins=0)
            self._words.setMinimumHeight(QFontMetrics(font()).lineSpacing() + Space.XL + Space.XS)  # that of a notice
        # The number of each step above its buttons; Cancel in the corner that a hand reaches first.
        steps = QGridLayout()
        steps.setHorizontalSpacing(Space.L)
        steps.setVerticalSpacing(Space.XS)
        starts = in_row(self.rehearse, self.choose, 1, spacing=Space.S)
        # Large text has no room for all steps side by side.
        last_row, last_column = (2, 0) if is_text_large() else (0, 2)
        for mark, buttons, row, column in (
            (self.marks[0], starts, 0, 0),
            (self.marks[1], in_row(self.arm, 1), 0, 1),
            (self.marks[2], in_row(self.hold, 1), last_row, last_column),
        ):
            steps.addWidget(mark, row, column)
            steps.addLayout(buttons, row + 1, column)
        steps.addWidget(self.cancel, last_row + 1, last_column + 1, Qt.AlignmentFlag.AlignRight)
        steps.setColumnStretch(last_column + 1, 1)
        for row in (0, last_row):  # the mark of the step that is due is larger
            steps.setRowMinimumHeight(row, QFontMetrics(font(is_bold=True)).height() + Space.XS)
        in_column(self._head, steps, of=self, spacing=Space.XS, margins=(Space.M, Space.S))
        # Cancel has the focus at every step: one Tab leads to the next one.
        for first, second in pairwise((self.rehearse, self.choose, self.cancel, self.arm, self.hold)):
            self.setTabOrder(first, second)


def _ended_notice(why: Input) -> Notice:
    text = tr("Disarmed: {why}. Nothing was sent.", why=tr(_ENDED[why]))
    return Notice(Meaning.INFORMATION, text)
