"""Texts for unmet conditions and outcomes of acts, shared by rows, ritual and baud rate."""

from dataclasses import replace
from typing import Final

from app.engine.target import sets_rate
from app.procedures.act import Performed
from app.safety.acts import TITLES, Act
from app.safety.interlocks import Interlock, Refusal, inputs_at, refusals
from app.safety.journal import Outcome
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.sentences import labelled
from protocol.translatable import marked
from ui.services.context import Services
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
