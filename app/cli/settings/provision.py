"""`dps-s provision --profile FILE --names M-001..M-050`: a batch of new modules, one after the other at one port.

Each module is read, gets the settings of the profile, verified, has both triggers enabled, is checked, gets the next
name, and its record is kept. What fails keeps no name and is set aside with its reason. Nothing is written to a module
that is ACTIVE or may be a known one, and nothing at all without --yes. The same command again goes on with the names
that are left. Exit code 0 if all names are given, 1 if not, 4 if a file could not be written or the store is lost.
"""

import argparse
import os
import time
from collections.abc import Callable, Sequence
from math import inf
from pathlib import Path
from typing import Final

from app.cli.results import ProvisionedJson, ProvisionJson
from app.cli.settings.set import warn
from app.engine.procedure import await_asking
from app.fleet.batch import PLUG_IN, READY, SET_ASIDE, TAKEN, UNPLUG, BatchRow, Bench, ModuleBatch, batch_of
from app.fleet.batch_list import cells, check_batch_target, is_done, write_batch_labels, write_list
from app.modules.labels import PAPERS
from app.preflight.evidence import Evidence
from app.preflight.findings import Person
from app.preflight.provision import await_gone
from app.procedures.write_all import WriteContext
from app.store.fact_store import Store
from app.store.trouble import StoreTrouble
from app.terminal import console
from app.terminal.arguments import add_file, add_json, add_port, add_yes, any_name, batch_names
from app.terminal.command_journal import opened_store, records_on
from app.terminal.connection import Conversation, LinkTrouble, connected
from app.terminal.console import Colour, coloured
from app.terminal.interruption import Interruption
from app.terminal.setting_words import typed
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.sentences import join_sentences, not_written
from app.text.user_error import UserError

_LOOKS: Final = 5
_POLL_EVERY_S: Final = 0.1
"""Pauses between two attempts to find a module."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_file(parser, "--profile", type=Path, required=True, metavar="FILE", help="write all settings of this profile")
    parser.add_argument(
        "--names", type=batch_names, required=True, metavar="M-001..M-050", help="names, one for each module"
    )
    parser.add_argument("--enable-triggers", action="store_true", help="enable both automatic triggers")
    add_yes(parser)
    parser.add_argument("--accept-risk", action="store_true", help="write values that take protection away")
    parser.add_argument(
        "--records-reviewed",
        action="store_true",
        help="the trigger records were judged; a module that never answers their query is new",
    )
    parser.add_argument(
        "--all-new", action="store_true", help="all modules are new, also those that resemble a known one"
    )
    parser.add_argument("--who", type=any_name, default="", metavar="NAME", help="who checks")
    add_file(parser, "--list", type=Path, metavar="FILE.pdf", help="write the list of the batch, and FILE.csv")
    add_file(parser, "--labels", type=Path, metavar="FILE.pdf", help="print labels into this file")
    parser.add_argument(
        "--tape", choices=("62", "24", "A4"), default="A4", help="paper of the labels: width in mm, or sheets"
    )
    add_port(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    batch = batch_of(args.profile, args.names, args.baud)
    args.baud = args.baud or batch.profile.settings.get("baud_rate")
    files = [path for path in (args.labels, args.list) if path is not None]
    for path in files:
        check_batch_target(path)
    if len({os.path.realpath(path).casefold() for path in files}) < len(files):  # one would replace the other
        raise console.Refused(tr("{name} is given twice.", name=args.list))
    if not args.yes:
        if not args.json:
            settings = [(change.command.key, typed(change.value)) for change in batch.changes]
            console.write_lines(
                [
                    tr("Each module gets these settings and both triggers, is checked and named:"),
                    *console.columns(settings, indent=2),
                    f"  {batch.title}",
                ]
            )
        console.refuse_without("--yes")
    warn(batch.changes)
    if any(change.risks for change in batch.changes) and not args.accept_risk:
        console.refuse_without("--accept-risk")
    if not args.enable_triggers and not batch.enables_triggers:
        console.refuse_without("--enable-triggers")
    person = Person(who=args.who, are_records_reviewed=args.records_reviewed, is_named_by_option=True)
    with (
        Interruption(),
        opened_store() as (store, troubles),
    ):  # after the last module a signal keeps nothing from being told
        bench = Bench(batch, store, person, is_enabling=args.enable_triggers, are_all_new=args.all_new,
                      accepted=frozenset(batch.changes if args.accept_risk else ()))  # fmt: skip
        trouble: BaseException | None = None
        try:
            with Interruption() as interruption:
                _Turns(bench, store, troubles, args, interruption).run()
        except (KeyboardInterrupt, StoreTrouble, BrokenPipeError, console.OutputLost) as error:
            trouble = error
        rows = store.write(bench.rows).result()  # behind what is still being kept
        is_written = _write_files(args, batch, rows)
        modules = [_provisioned(row) for row in rows]
        answer = ProvisionJson(modules=modules, complete=is_done(rows))
        console.emit(args, answer, ["", *console.columns([cells(row) for row in rows])])
    if isinstance(trouble, StoreTrouble):
        console.notify(join_sentences((trouble.sentence, tr("Not kept."))))
        return console.PARTIAL
    if trouble is not None:
        raise trouble
    if not is_written:
        return console.PARTIAL
    return console.SUCCESS if is_done(rows) else console.ANSWER_NO


class _Turns:
    """Takes one module after the other at one port."""

    def __init__(
        self,
        bench: Bench,
        store: Store,
        troubles: list[UserMessage],
        args: argparse.Namespace,
        interruption: Interruption,
    ) -> None:
        self._bench, self._store, self._args, self._interruption = bench, store, args, interruption
        self._troubles = troubles
        self._last_sentence = ""
        self._taken: set[str] = set()

    def run(self) -> None:
        while name := self._next_name():
            self._take(name)
            self._interruption.check()

    def _next_name(self) -> str:
        """Another program may give some, too."""
        names, taken = self._store.read(self._bench.left)
        for name in taken:
            if name not in self._taken:
                console.notify(tr(TAKEN, module=name))
        self._taken |= set(taken)
        return next(iter(names), "")

    def _take(self, name: str) -> None:
        """Wait for a module, and for its end."""
        self._say(tr(PLUG_IN, module=name))
        evidence = Evidence(port=self._args.port)
        with (
            LinkTrouble() as link,
            connected(self._args.port, self._args.baud, interruption=self._interruption,
                      on_batch=lambda batch: evidence.listen(batch.events)) as conversation,
        ):  # fmt: skip
            self._last_sentence = ""
            self._tell(tr("A module answers: leave it plugged in."))
            self._provision(name, conversation, evidence)
            return
        console.show_progress(link.sentence or "")
        for _ in range(_LOOKS):
            self._interruption.check()
            time.sleep(_POLL_EVERY_S)

    def _provision(self, name: str, conversation: Conversation, evidence: Evidence) -> None:
        done = None
        records = records_on(self._store, self._troubles, self._args.port, origin="provision")
        try:
            with LinkTrouble():
                done = conversation.run(self._bench.provision(evidence, WriteContext(journal=records.journal)))
        except KeyboardInterrupt:
            console.notify(tr("Interrupted; may have been carried out."))
            raise
        keeping = self._store.write(lambda facts: self._bench.keep(facts, name, evidence, done, records.adapter()))
        with LinkTrouble():
            conversation.run(await_asking(keeping, inf))
        why = keeping.result()
        if why is None:
            console.write_lines([coloured(f"{name}: {tr(READY)}", Colour.GOOD)])
        else:
            console.write_lines([coloured(f"{tr(SET_ASIDE)}: {why.translated()}", Colour.BAD)])
        if not self._next_name():
            return
        self._say(tr(UNPLUG))
        with LinkTrouble():
            if done is not None:
                conversation.run(await_gone(done.presence))

    def _say(self, sentence: str) -> None:
        """Once, in large letters."""
        if sentence != self._last_sentence:
            self._last_sentence = sentence
            self._tell(coloured(sentence, Colour.LARGE))

    def _tell(self, line: str) -> None:
        """With --json standard output has the result only."""
        if self._args.json:
            console.notify(line)
        else:
            console.write_lines([line])


def _provisioned(row: BatchRow) -> ProvisionedJson:
    return ProvisionedJson(name=row.name, state=row.result, why="" if row.why is None else row.why.in_english())


def _write_files(args: argparse.Namespace, batch: ModuleBatch, rows: Sequence[BatchRow]) -> bool:
    """The labels of the names that are given, and the list as PDF and CSV."""
    is_written = True
    works: list[tuple[Path | None, Callable[[Path], None]]] = [
        (args.list, lambda path: write_list(path, batch, rows, args.printer)),
        (args.labels, lambda path: write_batch_labels(path, rows, PAPERS[args.tape], args.printer)),
    ]
    for path, write in works:
        if path is None:
            continue
        try:
            write(path)
        except (UserError, OSError, RuntimeError) as error:
            console.notify(not_written(path, error))
            is_written = False
    return is_written
