"""`dps-s activate | zero | shutdown`: one act, with --yes. There is no `dps-s deploy`.

Without --yes nothing is opened and nothing is sent. With it the engine still refuses if a condition is not met.
Exit code 0 confirmed by the module; 1 refused, or sent and not confirmed; 2 without --yes; 3 no link.

An activation that was interrupted after its frame had left is followed by LOCK, for which the command waits.
"""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

from app.procedures.act import Performed, perform
from app.procedures.lock import Locked
from app.safety.journal import EFFECTS, Act, Outcome
from app.safety.permit import Interlock, Origin, Permit
from app.system.clock import steady_time
from app.terminal import console
from app.terminal.arguments import add, add_port
from app.terminal.connection import OpenPort, connected
from app.terminal.interruption import limit_time, signals_noted
from app.terminal.records import records_of
from app.terminal.results import Result
from app.text.i18n import tr
from app.text.messages import join_sentences


class ActJson(Result):
    """`outcome`: what the module reported afterwards; "not sent" where a condition was not met."""

    act: str
    outcome: Literal["confirmed", "refused", "unknown", "not sent"]
    sentence: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    add(parser, "--yes", "--json")


def run(args: argparse.Namespace) -> int:
    act = Act(args.command)
    refuse_without_yes(args, act)
    with signals_noted():  # after the last frame a signal no longer keeps the outcome from being printed
        with records_of(args.port) as records, connected(args.port, args.baud, journal=records.journal) as opened:
            permit = permit_for(act, opened)
            with interruption_told():
                done = opened.run(perform(act, records.journal, permit=permit))
            pay_owed_lock(opened)
        return print_outcome(args, act, done)


def permit_for(act: Act, opened: OpenPort) -> Permit:
    """A person's word for this act, in the conversation that goes on."""
    return Permit(act, Origin.COMMAND_LINE, steady_time(), opened.number)


def refuse_without_yes(args: argparse.Namespace, act: Act) -> None:
    """Say what the act would do, and raise `Refused`, where --yes is missing."""
    if not args.yes:
        if not args.json:
            console.write_lines([tr(EFFECTS[act])])
        console.refuse_without("--yes")


@contextmanager
def interruption_told(*, is_sending: bool = True) -> Iterator[None]:
    """Where a signal ends what sends frames that change something, it is said that they may have been carried out."""
    try:
        yield
    except KeyboardInterrupt:
        if is_sending:
            console.notify(tr("Interrupted; may have been carried out."))
        raise


def pay_owed_lock(opened: OpenPort) -> None:
    """After an activation that was interrupted: wait until the module that answers then was locked."""
    if not opened.owes_lock:
        return
    limit_time(None)  # it has its own limit
    locked = opened.pay_owed_lock()
    if locked is not None and locked.is_locked:
        console.notify(join_sentences((tr("LOCK was sent after the interruption."), locked.sentence)))
    else:
        console.notify(tr("ACTIVE, not locked."))


def print_outcome(args: argparse.Namespace, act: Act, done: Performed | Locked) -> int:
    """Returns the exit code."""
    code = _exit_code(done)
    if args.json or code == console.SUCCESS:
        console.emit(args, ActJson(act.value, done.outcome.value, done.sentence), [done.sentence])
    if code != console.SUCCESS:
        console.notify(done.sentence)
    return code


def _exit_code(done: Performed | Locked) -> int:
    if isinstance(done, Locked):
        if done.is_locked:
            return console.SUCCESS
        return console.ANSWER_NO if done.is_heard and not done.is_port_lost else console.NO_LINK
    if done.outcome is Outcome.CONFIRMED:
        return console.ANSWER_NO if done.act is Act.ZERO and not done.is_level else console.SUCCESS
    is_silent = any(refusal.condition is Interlock.ONLINE for refusal in done.refusals)
    has_ended = done.outcome is Outcome.NOT_SENT and done.interrupted is not None
    return console.NO_LINK if is_silent or has_ended else console.ANSWER_NO
