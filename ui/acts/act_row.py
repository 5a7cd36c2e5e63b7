"""The row of one dangerous act: description, unmet conditions, confirmation, and what came of it in words."""

from dataclasses import replace
from functools import partial
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QFrame, QStackedLayout, QWidget

from app.engine.procedure import Job
from app.engine.target import sets_rate
from app.fleet.card import Need
from app.procedures.act import Performed, perform
from app.safety.journal import EFFECTS, TITLES, Act, Outcome
from app.safety.permit import Interlock, Origin, Permit, Refusal, inputs_at, refusals
from app.text.i18n import tr
from app.text.messages import UserMessage, duration, join_names, labelled
from protocol.translatable import marked
from ui.acts.confirm import Confirm
from ui.services.context import Services
from ui.session.ports import Ports
from ui.session.shown_module import RunningJob, ShownModule
from ui.style.theme import Meaning, Space, font
from ui.widgets.controls import ElidedLabel, in_column, in_row, named, retain_size, stacked, text_label
from ui.widgets.notice_bar import Notice, NoticeBar

ASKING: Final = marked("Asking the module…")
# What the person is about to do: not shown as an open condition.
_ASKED_ANYWAY: Final = (Interlock.CONFIRMED, Interlock.RITUAL_DONE)


def open_conditions(services: Services, act: Act) -> tuple[Refusal, ...]:
    """Open conditions of `act`, apart from the person's confirmation."""
    port, module = services.ports.current, services.ports.module
    if not port.is_open:
        return (Refusal(Interlock.ONLINE, UserMessage(marked("Not connected"))),)
    inputs = replace(
        inputs_at(module.view, port.now_s),
        armed=services.armed.act,
        is_audit_ready=module.journal.is_ready,
        sets_rate=sets_rate(port.connection.port),
    )
    return tuple(refusal for refusal in refusals(act, inputs) if refusal.condition not in _ASKED_ANYWAY)


def outcome_meaning(done: Performed) -> Meaning:
    if done.is_rehearsal:
        return Meaning.INFORMATION
    match done.outcome:
        case Outcome.UNKNOWN:
            return Meaning.DANGER
        case Outcome.CONFIRMED:
            is_hot = done.act in (Act.ACTIVATE, Act.DEPLOY) or (done.act is Act.ZERO and not done.is_level)
            return Meaning.DANGER if done.act is Act.DEPLOY else Meaning.ATTENTION if is_hot else Meaning.GOOD
        case _:
            return Meaning.ATTENTION


def not_begun() -> Notice:
    return Notice(Meaning.ATTENTION, tr("Link lost. Nothing was sent."))


def keep_interrupted(module: ShownModule, done: Performed) -> None:
    """What left and was interrupted stays as a notice of the port: the next conversation shows nothing of this one."""
    if done.interrupted is not None and done.outcome is not Outcome.NOT_SENT:
        module.keep_report(UserMessage(labelled(tr(TITLES[done.act]), done.sentence)))


def outcome_notice(done: Performed) -> Notice:
    return Notice(outcome_meaning(done), done.sentence)


class ActRow(QFrame):
    """`refresh` updates the open conditions. `place` distinguishes rows of the same act on several pages."""

    begun = Signal()
    """The act was confirmed and is being sent."""
    ended = Signal(object)
    """The `Performed`; None if the connection was lost before."""

    def __init__(self, services: Services, act: Act, *, place: str = "act") -> None:
        super().__init__()
        name = f"{place}_{act.value}"
        named(self, name, "row")
        self.act = act
        self._services, self._ports = services, services.ports
        self._performed: Performed | None = None
        self._title = text_label(f"{name}_title", "strong")
        self._effect = text_label(f"{name}_effect", "small")
        self.live = named(ElidedLabel(), f"{name}_live", "small")
        # On Pre-flight the verdict stands above.
        self._shows_verdict = act is Act.ACTIVATE and place == "act"
        self.live.setVisible(act is Act.ZERO or self._shows_verdict)
        self.conditions = text_label(f"{name}_conditions", "attention")
        # Stacked, so that a notice never changes the height of the row.
        self._place, self._words, self._reasons = QStackedLayout(), QWidget(), QStackedLayout()
        self.confirm = Confirm(name, ask=f"{TITLES[act]}…", go=TITLES[act])
        self.notice_bar = named(NoticeBar(), f"{name}_said")
        self._title.setText(tr(TITLES[act]))
        self._effect.setText(tr(EFFECTS[act]))
        self.confirm.confirmed.connect(self._perform)
        self.confirm.asked.connect(self._dismiss)
        self._lay_out()
        self._ports.shown.connect(self._on_shown)

    @property
    def _job(self) -> RunningJob:
        """Of the module shown; what came of it is shown on no other."""
        return self._ports.module.job(self.objectName())

    def _on_shown(self, _module: ShownModule) -> None:
        self._performed = None
        self.confirm.withdraw()
        self.refresh()

    def refresh(self) -> None:
        if _has_turned(self._services, self._performed):
            self._dismiss()
        refusals = open_conditions(self._services, self.act)
        # What is armed is visible on this page; another line in each row would move the button under the hand.
        shown = [refusal for refusal in refusals if refusal.condition is not Interlock.NOTHING_ELSE_ARMED]
        # One condition at a time: a second line would move the rows below. Without a module, or with perhaps another
        # one, all other conditions follow from that.
        is_first = (Interlock.ONLINE, Interlock.NOT_SHARED, Interlock.LINE_IS_QUICK)
        shown.sort(key=lambda refusal: refusal.condition not in is_first)
        self.conditions.setText(shown[0].sentence if shown else "")
        # An old status does not disable the button: the engine asks for a new one before it decides.
        blocking = [refusal for refusal in refusals if refusal.condition is not Interlock.FRESH_STATUS]
        if self.act is Act.ZERO:
            self.live.setText("" if shown else _motion_text(self._ports))  # the condition gives the figures
        elif self._shows_verdict:
            self.live.setText(_verdict_text(self._ports.module))
        self.confirm.set_possible(not blocking and not self._job.is_running)
        notice = self._job.notice(ASKING, can_cancel=False)
        self.notice_bar.show_notice(notice)
        self._place.setCurrentWidget(self._words if notice is None else self.notice_bar)
        self._reasons.setCurrentWidget(self.conditions if shown else self._effect)

    def _perform(self) -> None:
        module, act = self._ports.module, self.act
        permit = Permit(act, Origin.CONFIRMATION, self._ports.clock(), module.number)
        self._performed = None
        if act is Act.ACTIVATE:
            self._ports.current.lock.give_up()
        self.begun.emit()
        performing = perform(act, module.journal, permit=permit, armed=self._services.armed)
        self._job.run(performing, partial(self._end, module))

    def _end(self, module: ShownModule, job: Job[Performed]) -> None:
        if job.error is not None:
            module.job(self.objectName()).set_notice(not_begun())
            self.ended.emit(None)
            return
        self._performed = done = job.outcome()
        if done.act is Act.SHUTDOWN and done.outcome is Outcome.CONFIRMED and not done.is_rehearsal:
            self._ports.current.note_shutdown()
        module.job(self.objectName()).set_notice(outcome_notice(done))
        keep_interrupted(module, done)
        self.ended.emit(done)

    def _dismiss(self) -> None:
        self._performed = None
        self._job.dismiss()

    def _lay_out(self) -> None:
        self._title.setWordWrap(False)
        for label in (self._effect, self.conditions):
            label.setAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop)
        for part in (self._effect, self.conditions, self._words, self.notice_bar):
            retain_size(part)  # as high for any of them
        stacked(self._reasons, self._effect, self.conditions)
        head = in_row(self._title, (self.live, 1), spacing=Space.M)
        in_column(head, self._reasons, of=self._words, spacing=2, margins=0)
        self._words.setMinimumHeight(2 * QFontMetrics(font()).lineSpacing() + Space.M)  # that of a notice
        stacked(self._place, self._words, self.notice_bar)
        in_row((self._place, 1), self.confirm, of=self, spacing=Space.L, margins=(Space.M, Space.XS))


def _has_turned(services: Services, done: Performed | None) -> bool:
    """Whether a notice of an activation is no longer true: it was confirmed, and the module reports that it is not
    active any more; or it is unknown, and the module was locked since."""
    if done is None or done.act is not Act.ACTIVATE:
        return False
    module = services.ports.module
    is_active = module.view.fresh("active", module.now_s)
    if done.outcome is Outcome.CONFIRMED:
        return is_active is not True
    return done.outcome is Outcome.UNKNOWN and services.ports.current.lock.is_reported


def _verdict_text(module: ShownModule) -> str:
    """The last verdict of a module with its age, or why it holds no more."""
    if module.is_checking:
        return labelled(tr("Verdict"), tr("checking…"))
    held = None if module.check is None else module.check.held
    if held is None or held.at is None:
        return labelled(tr("Verdict"), tr("not checked"))
    if held.verdict is None:
        why = "" if held.void is None else held.void.message.translated()
        return tr(Need.VOID.value, why=why)
    age = tr("{time} ago", time=duration(module.now_s - held.at))
    return labelled(tr("Verdict"), join_names((tr(held.verdict.value), age)))


def _motion_text(ports: Ports) -> str:
    """The current input of zeroing; empty if unknown."""
    view = ports.module.view
    motion, tilt = view.motion, view.fresh("tilt_deg", ports.clock())
    if motion is None or tilt is None:
        return ""
    return tr(
        "{tilt:.0f}°, {low:.1f}–{high:.1f} g, moved {change:.0f}° in 2 s",
        tilt=tilt,
        low=motion.acceleration_low_g,
        high=motion.acceleration_high_g,
        change=motion.tilt_change_deg,
    )
