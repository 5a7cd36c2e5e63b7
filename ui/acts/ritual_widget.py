"""Deploy panel: choose, arm, hold. `app.safety.ritual` decides; this holds the controls and the timer.

Fifty times a second it checks for what disarms: an open condition, the end of the conversation, another window or
field, an error anywhere in the window, an armed control that is not visible. Cancel has the focus at every
step, and each control has its own place at the bottom of the page.
"""

from functools import partial
from itertools import pairwise
from typing import Final

from PySide6.QtCore import QEvent, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QFontMetrics, QHideEvent, QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPaintEvent
from PySide6.QtWidgets import (
    QFrame,
    QGridLayout,
    QLabel,
    QProgressBar,
    QStackedLayout,
    QStyle,
    QStyleOptionButton,
    QWidget,
)

from app.engine.procedure import Job
from app.procedures.act import Performed, perform
from app.safety.journal import EFFECTS, REQUESTS, TITLES, Act
from app.safety.ritual import ARMED_FOR_S, HOLD_S, Input, Ritual, Stage
from app.text.i18n import tr
from app.text.messages import join_sentences, labelled
from protocol.translatable import marked
from ui.acts.act_row import is_blocked, open_conditions, say_outcome
from ui.services.context import Services
from ui.session.page_job import PageJob
from ui.session.shown_module import ShownModule
from ui.style.appearance import announce
from ui.style.theme import Meaning, Size, Space, current, font, is_text_large
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
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.notices import Notice
from ui.widgets.step_button import (
    PRESS_KEYS,
    StepButton,
    bring_into_sight,
    gestures,
    has_focus,
    is_in_sight,
    leave_focus,
)

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


class HoldButton(StepButton):
    """Must be held, by mouse or keyboard; never emits `clicked`, and ignores auto-repeat. `share` (0 … 1) of the hold
    fills it."""

    # A valid press has begun; it was released, or the pointer left, or something else was pressed.
    hold_started = Signal()
    hold_ended = Signal()

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._share = 0.0
        self._held_by_key = False
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def show_share(self, share: float) -> None:
        if share != self._share:
            self._share = share
            self.update()

    def _hold(self, *, by_key: bool) -> None:
        self._is_pressed, self._held_by_key = True, by_key
        self.setDown(True)
        self.hold_started.emit()

    def cancel_press(self) -> None:
        was_held = self._is_pressed
        super().cancel_press()
        if was_held:
            self.hold_ended.emit()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        event.accept()
        if event.button() is not Qt.MouseButton.LeftButton or self._is_pressed:
            self.cancel_press()  # another button during a hold
        elif self.counts(event):
            self.setFocus(Qt.FocusReason.MouseFocusReason)
            self._hold(by_key=False)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        event.accept()
        if not self.rect().contains(event.position().toPoint()):
            self.cancel_press()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        event.accept()
        self.cancel_press()

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        if not self._held_by_key:
            self.cancel_press()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        self.check_place()
        event.setAccepted(event.key() in PRESS_KEYS)  # Esc and Tab are the widget's around it
        if not event.isAccepted() or event.isAutoRepeat():
            return
        if self._is_pressed:
            self.cancel_press()
        elif self.takes_keys:
            self._hold(by_key=True)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        event.setAccepted(event.key() in PRESS_KEYS)
        if event.isAccepted() and not event.isAutoRepeat():
            self.cancel_press()

    def initStyleOption(self, option: QStyleOptionButton) -> None:
        super().initStyleOption(option)
        option.state &= ~QStyle.StateFlag.State_Sunken

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self._share > 0:
            painter = QPainter(self)
            tint = current().danger if self.property("role") == "danger" else current().information
            outline = QPainterPath()
            outline.addRoundedRect(QRectF(self.rect()).adjusted(2, 2, -2, -2), 5, 5)
            painter.setClipPath(outline)
            done = QRectF(0, 0, self.width() * self._share, self.height())
            painter.fillRect(done, QColor(tint.fill))
            painter.setClipRect(done, Qt.ClipOperation.IntersectClip)
            painter.setPen(QColor(tint.on_fill))
            painter.setFont(self.font())
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, self.text())
            painter.end()


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
        self._effect = text_label("ritual_effect", "small", tr(EFFECTS[Act.DEPLOY]))
        self.conditions = text_label("ritual_conditions", "attention")
        self.step = named(QLabel(), "ritual_step", "strong")
        self.marks = [
            named(QLabel(tr("Step {number}: {name}", number=number, name=tr(title))), f"ritual_step_{name}")
            for number, (name, title) in enumerate(_STEPS, 1)
        ]
        self.countdown = named(QProgressBar(), "ritual_countdown", says=tr("Disarms in"))
        self.countdown.setTextVisible(False)
        self.countdown.setRange(0, round(ARMED_FOR_S * 1000))
        tip = tr("Arm, then hold for two seconds. Letting go, Esc or leaving the page sends nothing.")
        self.choose = control(StepButton(tr("Deploy…")), "ritual_choose", role="danger", tip=tip)
        self.choose.chosen.connect(self._choose)
        self.arm = control(StepButton(tr("Arm for 10 s")), "ritual_arm", role="danger", slot=self._arm)
        self.hold = control(
            HoldButton(tr("Hold to DEPLOY")), "ritual_hold", role="danger", tip=tr("Mouse or space bar")
        )
        self.hold.ensurePolished()
        self.hold.setMinimumSize(self.hold.sizeHint().expandedTo(QSize(180, 44)))  # for a gloved finger
        self.hold.hold_started.connect(self._press)
        self.hold.hold_ended.connect(self._release)
        cancel = StepButton(tr("Cancel"), is_safe=True)
        self.cancel = control(cancel, "ritual_cancel", tip=tr("Nothing is sent."), key="Esc")
        self.cancel.chosen.connect(partial(self.disarm, Input.CANCEL))
        self.notice_bar = named(NoticeBar(), "ritual_said")
        self._ports.changed.connect(self._watch)
        self._ports.shown.connect(self._on_another_module)
        self._ports.leaving.connect(partial(self.disarm, Input.INTERRUPTED))
        self._ports.failed.connect(partial(self.disarm, Input.FAILED))
        self._ports.chosen.connect(self._forget_disarmed)
        self._timer = QTimer(self, interval=TICK_MS, timerType=Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._tick)
        self._lay_out()
        self._show()

    def _lay_out(self) -> None:
        # Stacked, each as high as the others, so that neither a reason nor a notice changes the height of the panel.
        self._words, self._reasons, self._head = named(QWidget(), "ritual_words"), QStackedLayout(), QStackedLayout()
        for part in (self._effect, self.conditions, self._words, self.notice_bar):
            retain_size(part)
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
        # Large text has no room for all steps side by side.
        last_row, last_column = (2, 0) if is_text_large() else (0, 2)
        buttons = (in_row(self.choose, 1), in_row(self.arm, 1), in_row(self.hold, 1))
        places = ((0, 0), (0, 1), (last_row, last_column))
        for mark, layout, (row, column) in zip(self.marks, buttons, places, strict=True):
            steps.addWidget(mark, row, column)
            steps.addLayout(layout, row + 1, column)
            # The mark of the step that is due is larger.
            steps.setRowMinimumHeight(row, QFontMetrics(font(is_bold=True)).height() + Space.XS)
        steps.addWidget(self.cancel, last_row + 1, last_column + 1, Qt.AlignmentFlag.AlignRight)
        steps.setColumnStretch(last_column + 1, 1)
        in_column(self._head, steps, of=self, spacing=Space.XS, margins=(Space.M, Space.S))
        # Cancel has the focus at every step: one Tab leads to the next one.
        for first, second in pairwise((self.choose, self.cancel, self.arm, self.hold)):
            self.setTabOrder(first, second)

    @property
    def is_under_way(self) -> bool:
        return self.ritual.stage in (Stage.CHOSEN, Stage.ARMED, Stage.HOLDING)

    @property
    def _job(self) -> PageJob:
        """The job of the module shown; what came of it is shown on no other."""
        return self._ports.module.job("ritual")

    def disarm(self, why: Input) -> None:
        if self.is_under_way:
            self.ritual.disarm(why)
            self._on_stage()

    # The gestures

    def _choose(self) -> None:
        if not is_in_sight(self):
            bring_into_sight(self)
            if is_in_sight(self):
                return  # it moved under the pointer; where there is no room for all of it, the watch says so
        self._conversation = self._ports.module.number
        self.ritual.choose(self._conversation)
        self._focus_cancel()
        self._job.dismiss()
        self._disarmed = None
        self._timer.start()
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

    def _watch(self) -> None:
        """Check the conversation and the conditions; called at every change and tick."""
        if not self.is_under_way:
            return
        module, ritual = self._ports.module, self.ritual
        controls = [button for button in (self.cancel, self.arm, self.hold) if not button.isHidden()]
        if module.number != self._conversation or not module.is_going:
            self.disarm(Input.INTERRUPTED)
        elif not self.isActiveWindow():
            self.disarm(Input.WINDOW_LEFT)
        elif not has_focus(self.hold if ritual.stage is Stage.HOLDING else self):
            self.disarm(Input.FOCUS_LOST)
        elif not all(map(is_in_sight, controls)):
            self.disarm(Input.OUT_OF_SIGHT)
        elif ritual.is_armed and self._services.armed.act is None:
            self.disarm(Input.FAILED)  # disarmed by an error anywhere in the program
        elif ritual.is_armed and open_conditions(self._services, Act.DEPLOY):
            self.disarm(Input.CONDITION_OPENED)

    def _on_another_module(self, _module: ShownModule) -> None:
        self.disarm(Input.INTERRUPTED)
        self.ritual.disarm(Input.FINISHED)  # the outcome is shown to nobody
        self._show()

    def _forget_disarmed(self) -> None:
        self._disarmed = None
        self.refresh()

    def _tick(self) -> None:
        try:
            self._watch()
            if gestures().is_release_uncertain:
                return  # known within about 50 ms
            permit = self.ritual.tick(self._ports.clock())
        except BaseException:
            self.disarm(Input.FAILED)
            raise
        module, job = self._ports.module, self._job
        if permit is not None:
            performing = perform(Act.DEPLOY, module.journal, permit=permit, armed=self._services.armed)
            job.run(performing, partial(self._end, job, module), can_cancel=False)
        self._on_stage()

    def _end(self, running: PageJob, module: ShownModule, job: Job[Performed]) -> None:
        self.ritual.disarm(Input.FINISHED)
        say_outcome(running, module, None if job.error is not None else job.outcome())

    def _on_stage(self) -> None:
        """Show the stage; clean up once it is IDLE or FIRED."""
        if not self.is_under_way and self._timer.isActive():
            self._timer.stop()
            self._services.armed.act = None
            gestures().ignore_keys_down()
            leave_focus(self)
            why = self.ritual.ended_by
            if self.ritual.stage is Stage.IDLE and why in _ENDED:
                text = tr("Disarmed: {why}. Nothing was sent.", why=tr(_ENDED[why]))
                self._disarmed = Notice(Meaning.INFORMATION, text, dismiss=self._forget_disarmed)
                announce(text)
        self._show()

    # Display

    def _show(self) -> None:
        ritual, now = self.ritual, self._ports.clock()
        stage, is_under_way = ritual.stage, self.is_under_way
        for widget, is_shown in (
            (self.cancel, is_under_way),
            (self.hold, ritual.is_armed),
            (self.arm, stage is Stage.CHOSEN),
            (self.choose, not is_under_way),
            (self.countdown, ritual.is_armed),
        ):
            widget.setVisible(is_shown)  # also what was never shown: it would appear with its parent
        self.countdown.setValue(round(ritual.armed_left_s(now) * 1000))
        self.hold.show_share(ritual.held_s(now) / HOLD_S)
        due = {Stage.CHOSEN: 1, Stage.ARMED: 2, Stage.HOLDING: 2}.get(stage, 0)
        for number, mark in enumerate(self.marks):
            is_now = number == due and is_under_way
            state = tr("done") if number < due else tr("now") if is_now else ""
            spoken = ", ".join(filter(None, (mark.text(), state)))
            if mark.accessibleName() != spoken:
                mark.setAccessibleName(spoken)
            set_role(mark, "danger" if is_now else "caption")
        text = ""
        if ritual.is_armed:
            text = tr("ARMED: {seconds:.0f} s.", seconds=ritual.armed_left_s(now))
        elif stage is Stage.CHOSEN:
            text = tr("It would send {frame}.", frame=REQUESTS[Act.DEPLOY].encode().hex(" ").upper())
        self.step.setText(text)
        self.refresh()

    def refresh(self) -> None:
        port, name = self._ports.current, self._ports.module.name
        title = tr(TITLES[Act.DEPLOY])
        if port.target is not None and port.is_open:
            device = port.target.device.removeprefix("/dev/").partition("?")[0]
            named_so = tr("{act}: {module} on {port}", act=title, module=name, port=device)
            title = named_so if name else labelled(title, device)
        self._title.setText(title)
        open_ones = open_conditions(self._services, Act.DEPLOY)
        self.conditions.setText(join_sentences(refusal.sentence for refusal in open_ones))
        self._reasons.setCurrentWidget(self.conditions if open_ones else self._effect)
        is_free = not self.is_under_way and not self._job.is_running
        self.choose.setEnabled(is_free and not is_blocked(open_ones))
        self.arm.setEnabled(self.ritual.stage is Stage.CHOSEN and not open_ones)
        disarmed = [] if self._disarmed is None else [self._disarmed]
        self.notice_bar.show_notices(self._job.notices or disarmed)
        self._head.setCurrentWidget(self.notice_bar if self.notice_bar.notice else self._words)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and self.is_under_way:
            self.disarm(Input.CANCEL)
        else:
            super().keyPressEvent(event)

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self.disarm(Input.WINDOW_LEFT)
