"""`dps-s activate | lock | zero | shutdown`: one act, with --yes. There is no `dps-s deploy`.

Without --yes nothing is opened and nothing is sent. With it the engine still refuses while a condition is open, and
names it. Exit code 0 confirmed by the module; 1 refused, or sent and not confirmed; 2 without --yes; 3 no link.
"""

import argparse
import shlex
import time
from typing import TYPE_CHECKING

from app.commands.console import DONE, NO_LINK, SAID_NO, USED_WRONGLY, add_port_arguments, say, write_lines
from app.i18n import tr

if TYPE_CHECKING:
    from app.procedures.act import Performed

NAMES = ("activate", "lock", "zero", "shutdown")
"""Also the values of `Act`. Deploying needs a person who holds a button."""


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    from app.acts import EFFECTS, Act

    for name in NAMES:
        effect = tr(EFFECTS[Act(name)])
        more = tr("Without --yes it says so and sends nothing (exit code 2). What is done is written to the audit log.")
        parser = subparsers.add_parser(name, description=f"{effect} {more}")
        add_port_arguments(parser)
        parser.add_argument("--yes", action="store_true", help=tr("really do it"))
        parser.set_defaults(run=run, act=name)


def run(args: argparse.Namespace) -> int:
    from app.acts import EFFECTS, Act

    act = Act(args.act)
    if not args.yes:
        write_lines([tr(EFFECTS[act])])
        port = shlex.quote(args.port)  # a URL may hold what a shell takes for its own
        say(tr("Nothing was sent. To do it, say dps-s {name} --port {port} --yes.", name=args.act, port=port))
        return USED_WRONGLY
    from app.commands.audited import records_of
    from app.commands.connection import connected
    from app.permit import Origin, Permit
    from app.procedures.act import perform

    with records_of(args.port) as records, connected(args.port, args.baud) as conversation:
        permit = Permit(act, Origin.COMMAND_LINE, time.monotonic())
        try:
            performed = conversation.run(perform(act, records.journal, permit=permit))
        except KeyboardInterrupt:
            say(tr("Interrupted: if the command had left already, it may have been carried out."))
            raise
    code = exit_code(performed)
    if code == DONE:
        write_lines([performed.sentence])
    else:
        say(performed.sentence)
    return code


def exit_code(performed: "Performed") -> int:
    from app.acts import Act
    from app.journal import Outcome
    from app.safety import Condition

    if performed.outcome is Outcome.CONFIRMED:
        return SAID_NO if performed.act is Act.ZERO and not performed.is_level else DONE
    is_silent = any(refusal.condition is Condition.ONLINE for refusal in performed.refusals)
    return NO_LINK if is_silent else SAID_NO
