"""`dps-s activate | zero | shutdown`: one act, with --yes. There is no `dps-s deploy`.

Without --yes nothing is opened and nothing is sent. With it the engine still refuses if a condition is not met.
Exit code 0 confirmed by the module; 1 refused, or sent and not confirmed; 2 without --yes; 3 no link.
"""

import argparse
import time

from app.cli.results import ActJson
from app.procedures.act import Performed, perform
from app.procedures.lock import Locked
from app.procedures.settings_reading import read_one_module
from app.safety.acts import EFFECTS, Act
from app.safety.interlocks import Interlock, Refusal
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from app.terminal import console
from app.terminal.arguments import add_json, add_port, add_yes
from app.terminal.command_journal import records_of
from app.terminal.connection import connected
from app.terminal.interruption import Interruption
from app.text.i18n import tr


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    add_yes(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    act = Act(args.command)
    if not args.yes:
        if not args.json:
            console.write_lines([tr(EFFECTS[act])])
        console.refuse_without("--yes")

    done: Performed
    with Interruption():  # after the last frame a signal no longer keeps the outcome from being printed
        with records_of(args.port) as records, connected(args.port, args.baud) as conversation:
            reading = conversation.run(read_one_module())
            permit = Permit(act, Origin.COMMAND_LINE, time.monotonic())
            try:
                if isinstance(reading, Refusal):
                    done = Performed(act=act, outcome=Outcome.NOT_SENT, refusals=(reading,))
                else:
                    done = conversation.run(perform(act, records.journal, permit=permit))
            except KeyboardInterrupt:
                console.notify(tr("Interrupted; may have been carried out."))
                raise
        return tell(args, act, done)


def tell(args: argparse.Namespace, act: Act, done: Performed | Locked) -> int:
    """Print the outcome; returns the exit code."""
    code = exit_code(done)
    is_done = code == console.SUCCESS
    if args.json or is_done:
        result = ActJson(act=act.value, outcome=done.outcome.value, sentence=done.sentence)
        console.emit(args, result, [done.sentence])
    if not is_done:
        console.notify(done.sentence)
    return code


def exit_code(done: Performed | Locked) -> int:
    if isinstance(done, Locked):
        if done.is_locked:
            return console.SUCCESS
        return console.ANSWER_NO if done.is_heard and not done.is_port_lost else console.NO_LINK
    if done.outcome is Outcome.CONFIRMED:
        return console.ANSWER_NO if done.act is Act.ZERO and not done.is_level else console.SUCCESS
    is_silent = any(refusal.condition is Interlock.ONLINE for refusal in done.refusals)
    return console.NO_LINK if is_silent else console.ANSWER_NO
