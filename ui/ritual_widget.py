"""Deploying, by ritual: choose, arm, hold. `app.ritual` decides; here are the hands, the eyes and the clock.

Fifty times a second it is looked whether anything disarms: a condition that opens, the link, a restart, a sleep of the
computer, another window, another field, an error anywhere in the window. Cancel has the focus at every step.
"""

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Final

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QHideEvent, QKeyEvent
from PySide6.QtWidgets import QApplication, QFrame, QHBoxLayout, QProgressBar, QPushButton, QVBoxLayout

from app.acts import EFFECTS, REQUESTS, TITLES, Act
from app.awake import SleepWatch, sleepless_clock
from app.i18n import tr
from app.permit import Permit
from app.procedures.act import Performed, perform, rehearse
from app.ritual import ARMED_FOR_S, HOLD_S, Input, Ritual, Stage
from app.worker import Job
from protocol.link_states import Presence
from protocol.text import marked
from ui.hold_button import HoldButton
from ui.labels import text_label
from ui.named import named
from ui.notice_bar import Notice, NoticeBar
from ui.outcomes import SameModule, asking, not_begun, open_conditions, outcome_notice
from ui.pages import Services
from ui.ritual_guard import RitualGuard
from ui.theme import Meaning, Space

TICK_MS: Final = 20
_BAR_PX: Final = 12
_ENDED: Final = {
    Input.CANCEL: marked("Cancelled. Nothing was sent."),
    Input.RAN_OUT: marked("The ten seconds are over. Nothing was sent."),
    Input.FOCUS_LOST: marked("Disarmed: the keyboard went elsewhere. Nothing was sent."),
    Input.WINDOW_LEFT: marked("Disarmed: the window was left. Nothing was sent."),
    Input.LINK_LOST: marked("Disarmed: the link was lost. Nothing was sent."),
    Input.MODULE_RESTARTED: marked("Disarmed: the module restarted. Nothing was sent."),
    Input.CONDITION_OPENED: marked("Disarmed: a condition is no longer fulfilled. Nothing was sent."),
    Input.SLEPT: marked("Disarmed: the computer slept. Nothing was sent."),
    Input.FAILED: marked("Disarmed: the program met an error. Nothing was sent."),
}


class RitualWidget(QFrame):
    """`refresh` brings the open conditions up to date."""

    grew = Signal()
    """It wants to be in sight as a whole."""

    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("ritual")
        self.setProperty("role", "danger-corner")
        self.ritual = Ritual(Act.DEPLOY)
        self._services, self._connector = services, services.connector
        self._restarts = 0
        self._was_online = False
        self._is_busy = False
        self._module = SameModule(services.connector)
        self.clock_with_sleep = sleepless_clock()
        """The clock that the ritual runs on may stand still while the computer sleeps: this one goes on."""
        self._sleeps = SleepWatch()
        self._done: Callable[[], Notice] | None = None
        texts = services.texts
        self._title = text_label("ritual_title", "strong")
        self._effect = text_label("ritual_effect", "small")
        self.conditions = text_label("ritual_conditions", "attention")
        self.step = text_label("ritual_step", "strong")
        self.countdown = named(QProgressBar(), "ritual_countdown")
        self.countdown.setTextVisible(False)
        self.countdown.setFixedHeight(_BAR_PX)
        self.countdown.setRange(0, round(ARMED_FOR_S * 1000))
        self.choose = self._button("ritual_choose", "danger")
        self.rehearse = self._button("ritual_rehearse", "")
        self.arm = self._button("ritual_arm", "danger")
        self.hold = named(HoldButton(), "ritual_hold")
        self.cancel = self._button("ritual_cancel", "")
        self.said = NoticeBar(texts)
        self.said.setObjectName("ritual_said")
        texts.bind(self._title.setText, TITLES[Act.DEPLOY])
        texts.bind(self._effect.setText, EFFECTS[Act.DEPLOY])
        texts.bind(self.countdown.setAccessibleName, "Time until it is disarmed")
        for button, english, tip in (
            (self.choose, marked("Deploy …"), marked("Begin: choose, arm, then hold for two seconds")),
            (self.rehearse, marked("Rehearse …"), marked("The whole ritual; nothing is sent at its end")),
            (self.arm, marked("Arm for 10 s"), marked("Arm: the next ten seconds it can be held")),
            (self.cancel, marked("Cancel"), marked("Disarm; nothing is sent (Esc)")),
        ):
            texts.bind(button.setText, english)
            texts.bind(button.setAccessibleName, english)
            texts.bind(button.setToolTip, tip)
        texts.bind(self.hold.setAccessibleName, "Hold for two seconds")
        texts.bind(self.hold.setToolTip, "Hold for two seconds, by mouse or by the space bar; letting go cancels")
        self.choose.clicked.connect(partial(self._choose, is_rehearsal=False))
        self.rehearse.clicked.connect(partial(self._choose, is_rehearsal=True))
        self.arm.clicked.connect(self._arm)
        self.cancel.clicked.connect(partial(self.disarm, Input.CANCEL))
        self.hold.pressed_down.connect(self._press)
        self.hold.let_go.connect(self._release)
        self._connector.changed.connect(self._watch)
        self._connector.batch.connect(lambda _batch: self._watch())
        services.appearance.changed.connect(self.said.follow_theme)
        self._guard = RitualGuard(self)
        self._guard.broken.connect(self.disarm)
        self._timer = QTimer(self)
        self._timer.setInterval(TICK_MS)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._tick)
        self._lay_out()
        self._show()

    @property
    def is_under_way(self) -> bool:
        return self.ritual.stage in (Stage.CHOSEN, Stage.ARMED, Stage.HOLDING)

    def refresh(self) -> None:
        if self._module.is_another() and not self.is_under_way:
            self._done = None
        found = open_conditions(self._services, Act.DEPLOY)
        self.conditions.setText(" ".join(one.sentence for one in found))
        self.conditions.setVisible(bool(found))
        is_free = not self.is_under_way and not self._is_busy
        self.choose.setEnabled(is_free and self._connector.is_open)
        self.rehearse.setEnabled(is_free)
        self.arm.setEnabled(self.ritual.stage is Stage.CHOSEN and (self.ritual.is_rehearsal or not found))
        self.said.show_notice(None if self._done is None else self._done())

    def disarm(self, why: Input, _is_checked: bool = False) -> None:
        """Back to the beginning; nothing is sent."""
        if self.is_under_way:
            self.ritual.disarm(why)
            self._follow()

    # The gestures

    def _choose(self, _is_checked: bool = False, *, is_rehearsal: bool) -> None:
        self.ritual.choose(is_rehearsal=is_rehearsal)
        self._done = None
        self._take_focus()
        self._show()
        self._begin_watching()

    def _arm(self) -> None:
        self.ritual.arm(self._connector.clock())
        self._services.armed.act = Act.DEPLOY
        self._take_focus()
        self._show()

    def _take_focus(self) -> None:
        """Before the button that has it is hidden: else the focus would wander off and disarm."""
        self.cancel.show()
        self.cancel.setFocus()
        QTimer.singleShot(0, self, self.grew.emit)

    def _press(self, is_auto_repeat: bool, is_double_click: bool) -> None:
        self.ritual.press(self._connector.clock(), is_auto_repeat=is_auto_repeat, is_double_click=is_double_click)

    def _release(self) -> None:
        self.ritual.release()

    # The watch

    def _begin_watching(self) -> None:
        device = self._connector.device
        self._restarts, self._was_online = device.restarts, device.presence is Presence.ONLINE
        self._sleeps = SleepWatch(with_sleep=self.clock_with_sleep)
        self._timer.start()
        self._guard.begin()

    def _watch(self) -> None:
        """What the link and the clocks say. Whatever disarms is found here or by the next tick."""
        if not self.is_under_way:
            return
        if self._sleeps.look():
            self.disarm(Input.SLEPT)
            return
        device = self._connector.device
        is_online = self._connector.is_open and device.presence is Presence.ONLINE
        if device.restarts != self._restarts:
            self.disarm(Input.MODULE_RESTARTED)
        elif self._was_online and not is_online:
            self.disarm(Input.LINK_LOST)
        elif self.ritual.is_armed and self._services.armed.act is None:
            self.disarm(Input.FAILED)  # an error in another thread took it away
        elif self.ritual.is_armed and not self.ritual.is_rehearsal and open_conditions(self._services, Act.DEPLOY):
            self.disarm(Input.CONDITION_OPENED)

    def _tick(self) -> None:
        try:
            self._watch()
            permit = self.ritual.tick(self._connector.clock())
        except BaseException:
            self.disarm(Input.FAILED)
            raise
        if permit is not None:
            self._fire(permit)
        self._follow()

    def _follow(self) -> None:
        """Show the stage; tidy up once it is back at the beginning."""
        if not self.is_under_way and self._guard.is_watching:
            self._timer.stop()
            self._guard.end()
            self._services.armed.act = None
            why = self.ritual.ended_by
            if self.ritual.stage is Stage.IDLE and why is not None and why in _ENDED:
                self._done = partial(_ended_notice, why, self._forget)
        self._show()

    # The end of it

    def _fire(self, permit: Permit) -> None:
        if permit.is_rehearsal:
            self._done = partial(outcome_notice, rehearse(Act.DEPLOY, permit), self._forget)
            self.ritual.disarm(Input.FINISHED)
            return
        connector = self._connector
        self._is_busy = True
        self._done = asking
        journal = self._services.keeping.journal(connector.target)
        connector.run(perform(Act.DEPLOY, journal, permit=permit, armed=self._services.armed), self._end)

    def _end(self, job: Job[Performed]) -> None:
        self._is_busy = False
        if job.run.error is not None:
            self._done = not_begun
        else:
            self._done = partial(outcome_notice, job.outcome(), self._forget)
        self.ritual.disarm(Input.FINISHED)
        self._show()

    def _forget(self) -> None:
        self._done = None
        self._show()

    def _show(self) -> None:
        ritual, now = self.ritual, self._connector.clock()
        stage = ritual.stage
        had_focus = self._has_focus_inside()
        for widget, is_shown in (
            (self.cancel, self.is_under_way),
            (self.hold, ritual.is_armed),
            (self.arm, stage is Stage.CHOSEN),
            (self.choose, not self.is_under_way),
            (self.rehearse, not self.is_under_way),
            (self.countdown, ritual.is_armed),
            (self.step, self.is_under_way),
        ):
            if widget.isHidden() is is_shown:
                widget.setVisible(is_shown)
        self.countdown.setValue(round(ritual.armed_left_s(now) * 1000))
        self.hold.show_share(ritual.held_s(now) / HOLD_S)
        rehearsal = tr("Rehearsal, nothing is sent.") if ritual.is_rehearsal else ""
        frame = REQUESTS[Act.DEPLOY].encode().hex(" ").upper()
        match stage:
            case Stage.CHOSEN:
                said = tr("Chosen. Next: arm it. {frame} is what would leave.", frame=frame)
            case Stage.ARMED | Stage.HOLDING:
                said = tr("ARMED for {seconds:.0f} s more. Hold the button for 2 s.", seconds=ritual.armed_left_s(now))
            case _:
                said = ""
        self.step.setText(f"{rehearsal} {said}".strip())
        self.hold.setText(tr("Hold to rehearse") if ritual.is_rehearsal else tr("Hold to DEPLOY"))
        self.refresh()
        if had_focus and not self._has_focus_inside() and self.isVisible():
            self.rehearse.setFocus()

    def _has_focus_inside(self) -> bool:
        focused = QApplication.focusWidget()
        return focused is not None and self.isAncestorOf(focused)

    # Qt

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and self.is_under_way:
            self.disarm(Input.CANCEL)
        else:
            super().keyPressEvent(event)

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self.disarm(Input.WINDOW_LEFT)

    @staticmethod
    def _button(name: str, role: str) -> QPushButton:
        button = named(QPushButton(), name)
        button.setProperty("role", role)
        button.setAutoDefault(False)
        return button

    def _lay_out(self) -> None:
        column = QVBoxLayout(self)
        column.setContentsMargins(Space.M, Space.M, Space.M, Space.M)
        column.setSpacing(Space.XS)
        for label in (self._title, self._effect, self.conditions, self.step):
            column.addWidget(label)
        column.addWidget(self.countdown)
        row = QHBoxLayout()
        row.setSpacing(Space.S)
        row.addStretch(1)
        for button in (self.arm, self.hold, self.rehearse, self.choose, self.cancel):
            row.addWidget(button)
        column.addLayout(row)
        column.addWidget(self.said)
        # From Cancel, which has the focus at every step, one Tab leads to what comes next.
        for first, second in pairwise((self.rehearse, self.choose, self.cancel, self.arm, self.hold)):
            self.setTabOrder(first, second)


def _ended_notice(why: Input, dismiss: Callable[[], None]) -> Notice:
    return Notice(Meaning.INFORMATION, tr(_ENDED[why]), dismiss=dismiss)
