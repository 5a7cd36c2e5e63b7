"""Texts for unmet conditions and outcomes of acts, shared by rows, ritual and baud rate."""

from dataclasses import replace
from typing import Final

from app.engine.target import sets_rate
from app.fleet.card import Need
from app.procedures.act import Performed
from app.safety.acts import TITLES, Act
from app.safety.interlocks import Interlock, Refusal, inputs_at, refusals
from app.safety.journal import Outcome
from app.text.durations import duration
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.sentences import join_names, labelled
from protocol.translatable import marked
from ui.services.context import Services
from ui.session.ports import Ports
from ui.session.shown_module import ShownModule
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Notice

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


def has_turned(services: Services, done: Performed | None) -> bool:
    """Whether a notice of an activation is no longer true: it was confirmed, and the module reports that it is not
    active any more; or it is unknown, and the module was locked since."""
    if done is None or done.act is not Act.ACTIVATE:
        return False
    module = services.ports.module
    is_active = module.view.fresh("active", module.now_s)
    if done.outcome is Outcome.CONFIRMED:
        return is_active is not True
    return done.outcome is Outcome.UNKNOWN and services.ports.current.lock.is_reported


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


def verdict_text(module: ShownModule) -> str:
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


def motion_text(ports: Ports) -> str:
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


def not_begun() -> Notice:
    return Notice(Meaning.ATTENTION, tr("Link lost. Nothing was sent."))


def keep_interrupted(module: ShownModule, done: Performed) -> None:
    """What left and was interrupted stays as a notice of the port: the next conversation shows nothing of this one."""
    if done.interrupted is not None and done.outcome is not Outcome.NOT_SENT:
        module.keep_report(UserMessage(labelled(tr(TITLES[done.act]), done.sentence)))


def outcome_notice(done: Performed) -> Notice:
    return Notice(outcome_meaning(done), done.sentence)
