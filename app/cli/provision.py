"""`dps-s provision --profile FILE --names M-001..M-050`: a batch of new modules, one after the other at one port.

Each module is read, gets the settings of the profile, verified, has both triggers enabled, is checked, gets the next
name, and its record is kept. What fails keeps no name and is set aside with its reason. Nothing is written to a module
that is ACTIVE or may be a known one, and nothing at all without --yes. The same command again goes on with the names
that are left. Exit code 0 if all names are given, 1 if not, 4 if the labels could not be written or the store is lost.
"""

import argparse
import time
from functools import partial
from typing import Final

from app.cli.set import warn
from app.engine.conversation import Interrupted
from app.fleet.batch import (
    EXAMPLE,
    FORMAT,
    OPEN,
    READY,
    SET_ASIDE,
    TAKEN,
    BatchRun,
    await_gone,
    batch_changes,
    batch_profile,
    counted_names,
    write_batch_labels,
)
from app.modules.labels import PAPERS
from app.preflight.checks import Person
from app.preflight.evidence import Evidence
from app.procedures.write import WriteContext
from app.records.report import check_target
from app.store.fact_store import StoreError
from app.terminal import console
from app.terminal.connection import LOST, connected
from app.terminal.records import CommandStore, say_not_kept
from app.terminal.results import Result
from app.text.i18n import tr
from app.text.messages import UserMessage, labelled
from protocol.catalogue import BAUD_RATE
from protocol.stale_replies import TRIGGER_FLAGS

LOOK_EVERY_S: Final = 0.5  # between two attempts to find a module


class ProvisionedJson(Result):
    """One name of a batch. `why` is empty where the module has its name."""

    name: str
    state: str
    why: str


class ProvisionJson(Result):
    modules: list[ProvisionedJson]
    complete: bool


def names(text: str) -> tuple[str, ...]:
    counted = counted_names(text)
    if counted is None:
        raise ValueError
    return counted


def add_arguments(parser: argparse.ArgumentParser) -> None:
    console.add_file(parser, "--profile", metavar="FILE", help="write all settings of this profile", required=True)
    parser.add_argument("--names", type=names, required=True, metavar=EXAMPLE, help="names, one for each module")
    parser.add_argument("--enable-triggers", action="store_true", help="enable both automatic triggers")
    parser.add_argument("--all-new", action="store_true", help="all modules are new, also those like a known one")
    parser.add_argument("--who", default="", metavar="NAME", help="who checks")
    console.add_file(parser, "--labels", metavar="FILE.pdf", help="print labels into this file")
    parser.add_argument("--tape", choices=tuple(PAPERS), default="A4", help="paper: width of the tape in mm, or sheets")
    console.add_flags(parser, "--yes", "--accept-risk", "--records-reviewed")


def run(args: argparse.Namespace) -> int:
    profile = batch_profile(args.profile)
    changes = batch_changes(profile)
    rate = profile.settings.get(BAUD_RATE.key)
    if rate not in (None, args.baud):
        console.notify(tr("The profile's {rate} baud is left out: a batch does not change it.", rate=rate))
    if args.labels is not None:
        check_target(args.labels, FORMAT)
    console.require("--yes", is_given=args.yes)
    warn(changes)
    console.require("--accept-risk", is_given=args.accept_risk or not any(change.risks for change in changes))
    # Without both triggers no module is READY.
    enables_triggers = all(profile.settings.get(command.key) is True for command in TRIGGER_FLAGS)
    console.require("--enable-triggers", is_given=args.enable_triggers or enables_triggers)
    person = Person(who=args.who, are_records_reviewed=args.records_reviewed)
    with CommandStore(args.port) as store:
        bench = BatchRun(args.names, profile, store, person, is_enabling=args.enable_triggers, are_all_new=args.all_new)
        code = console.PARTIAL
        try:
            _take_each(bench, store, args)
            code = console.SUCCESS
        except StoreError as trouble:
            say_not_kept(trouble)
        finally:  # what is done is told also after Ctrl-C
            rows = store.read(bench.rows)
            labels = partial(write_batch_labels, args.labels, rows, PAPERS[args.tape], args.printer)
            if args.labels is not None and not console.wrote(args.labels, labels):
                code = console.PARTIAL
            answer = ProvisionJson([], not any(row.result == OPEN for row in rows))
            cells: list[tuple[str, ...]] = []
            for row in rows:
                answer.modules.append(ProvisionedJson(row.name, row.result, row.why.in_english()))
                cells.append((row.name, tr(row.result), row.code, row.why.translated()))
            console.emit(args, answer, ["", *console.columns(cells)])
    return console.ANSWER_NO if code == console.SUCCESS and not answer.complete else code


def _take_each(bench: BatchRun, store: CommandStore, args: argparse.Namespace) -> None:
    """Take one module after the other, until no name is left. What to do is told on standard error."""
    accepted = frozenset(batch_changes(bench.profile) if args.accept_risk else ())

    def next_name() -> str:
        # Another program may give some, too.
        names, taken = store.read(bench.left)
        for name in taken:
            console.notify_once(tr(TAKEN, module=name))
        return names[0] if names else ""

    def take(name: str) -> None:
        evidence = Evidence(port=args.port)
        said: UserMessage | None = None
        store.renew()
        with connected(args.port, args.baud) as opened:
            console.notify(tr("A module answers: leave it plugged in."))
            try:
                context = WriteContext(journal=store.journal, accepted_risks=accepted)
                said = opened.run(bench.provision(evidence, context))
            except Interrupted as ended:
                evidence.note_error(ended)
            why = store.write_in_time(lambda facts: bench.keep(facts, name, evidence, said, store.where.adapter))
            aside = "" if why is None else labelled(tr(SET_ASIDE), why.translated())
            console.notify(aside or labelled(name, tr(READY)))
            if next_name():
                console.notify(tr("UNPLUG, NEXT"))
                if evidence.void is not None:
                    opened.bind()  # to the conversation after the one that was interrupted, if there is one
                # Another one may answer at once: it is the next one, and not waited for.
                if opened.conversation.is_going and opened.conversation.number == opened.number:
                    opened.run(await_gone())

    asked_for = ""
    while name := next_name():
        if name != asked_for:
            console.notify(tr("PLUG IN: {module}", module=name))
        asked_for = name
        try:
            take(name)
            asked_for = ""
        except LOST as error:
            console.notify_once(console.failure_of(error).sentence)
            # No port is open, so nothing is missed meanwhile.
            time.sleep(LOOK_EVERY_S)
        console.check_signals()
