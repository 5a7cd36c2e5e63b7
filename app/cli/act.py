"""`dps-s activate | zero | shutdown`: one act, with --yes. There is no `dps-s deploy`.

Without --yes nothing is opened and nothing is sent. With it the engine still refuses if a condition is not met.
Exit code 0 confirmed by the module; 1 refused, or sent and not confirmed; 2 without --yes; 3 no link.

An activation that was interrupted after its frame had left is followed by LOCK, for which the command waits.
"""

import argparse

from app.procedures.act import Performed, perform
from app.procedures.lock import Locked
from app.safety.journal import EFFECTS, Act, Outcome
from app.safety.permit import Interlock, Origin, Permit
from app.system.clock import steady_time
from app.terminal import console
from app.terminal.connection import OpenPort, connected
from app.terminal.records import CommandStore
from app.terminal.results import Result
from app.text.i18n import tr


class ActJson(Result):
    """`outcome`: what the module reported afterwards; "not sent" where a condition was not met."""

    act: str
    outcome: Outcome
    sentence: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    console.add_flags(parser, "--yes")


def run(args: argparse.Namespace) -> int:
    act = Act(args.command)
    refuse_without_yes(args, act)
    with CommandStore(args.port) as store, connected(args.port, args.baud, journal=store.journal) as opened:
        done = opened.run(perform(act, store.journal, permit=permit_for(act, opened)))
    return print_outcome(args, act, done)


def permit_for(act: Act, opened: OpenPort) -> Permit:
    # A person's word for this act, in the conversation that goes on.
    return Permit(act, Origin.COMMAND_LINE, steady_time(), opened.number)


def refuse_without_yes(args: argparse.Namespace, act: Act) -> None:
    """Say what the act would do, and raise `Refused`, where --yes is missing."""
    # With --json standard output holds one object, which is the refusal.
    if not args.yes and not args.json:
        console.write_lines([tr(EFFECTS[act])])
    console.require("--yes", is_given=args.yes)


def print_outcome(args: argparse.Namespace, act: Act, done: Performed | Locked) -> int:
    is_done = done.outcome is Outcome.CONFIRMED
    if isinstance(done, Locked):
        is_lost = done.is_port_lost or not done.is_heard
    else:
        is_done = is_done and (act is not Act.ZERO or done.is_level)
        is_lost = done.outcome is Outcome.NOT_SENT and done.interrupted is not None
        is_lost |= any(refusal.condition is Interlock.ONLINE for refusal in done.refusals)
    if args.json or is_done:
        console.emit(args, ActJson(act.value, done.outcome, done.sentence), [done.sentence])
    if is_done:
        return console.SUCCESS
    console.notify(done.sentence)
    return console.NO_LINK if is_lost else console.ANSWER_NO
