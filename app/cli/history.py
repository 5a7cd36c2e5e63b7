"""`dps-s history`: reads the trigger records.

The protocol does not tell how many records follow (E6), so they are read until two passes agree. Exit code 0 if they
agree and no frame was lost; 3 without a link; 4 if they differ, the query was not answered, or the link was lost.
"""

import argparse

from app.engine.identity import IdentityEvidence
from app.engine.worker import Batch
from app.procedures.history import History, Pass, history_of, read_history
from app.terminal import console
from app.terminal.connection import LinkTrouble, connected, module_is_silent
from app.terminal.record_table import csv_of, json_of, page_of, write_csv
from app.terminal.stored_history import read_evidence, store_visit
from app.text.i18n import tr
from app.text.sentences import not_written
from protocol.catalogue import TRIGGER_RECORDS
from protocol.events import Received, Role, Sent
from protocol.messages import EmptySlot, TriggerRecord


def run(args: argparse.Namespace) -> int:
    received = ReceivedRecords()
    history: History | None = None
    found = IdentityEvidence()
    with connected(args.port, args.baud, on_batch=received.on_batch) as conversation, LinkTrouble() as link:
        history = conversation.run(read_history())
        if args.module is not None:
            found = conversation.run(read_evidence())
    if history is None or link.sentence is not None:
        history = received.history()
    trouble = link.sentence or (module_is_silent(args.port, conversation.device) if history.is_line_dead else None)
    has_something = history.is_answered
    is_written = _print(history, args) if has_something or trouble is None else True
    if args.module is not None and has_something:
        is_written &= store_visit(history, args.module, port=args.port, found=found, is_same_module=args.same_module)
    if trouble is not None:
        console.notify(trouble)
        return console.PARTIAL if has_something else console.NO_LINK
    if not history.is_answered:
        console.notify(tr("{file}: {why}", file=tr("Trigger records"), why=tr("no reply")))
        return console.PARTIAL
    if not history.is_confirmed:
        console.notify(tr("The readings differ or frames were lost: records may be missing. Read again."))
        return console.PARTIAL
    return console.SUCCESS if is_written else console.PARTIAL


class ReceivedRecords:
    """The records as they came, by pass: the result if the port is lost meanwhile."""

    def __init__(self) -> None:
        self._passes: list[list[TriggerRecord | EmptySlot]] = []

    def on_batch(self, batch: Batch) -> None:
        for event in batch.events:
            match event:
                case Sent(request=request) if request.command is TRIGGER_RECORDS:
                    self._passes.append([])
                case Received(message=TriggerRecord() | EmptySlot() as message, role=Role.ANSWER):
                    self._passes[-1].append(message)
                case _:
                    pass

    def history(self) -> History:
        return history_of([Pass(tuple(one)) for one in self._passes], is_line_dead=True)


def _print(history: History, args: argparse.Namespace) -> bool:
    """Print or write the records; whether that succeeded."""
    if args.json:
        console.write_json(json_of(history))
        return True
    if args.csv is None:
        console.write_lines(page_of(history))
        return True
    if args.csv == "-":
        console.write(csv_of(history))
        return True
    try:
        write_csv(args.csv, history)
    except OSError as error:
        console.write_lines(page_of(history))  # so that no record is lost
        console.notify(not_written(args.csv, error))
        return False
    console.write_lines([tr("Rows written to {file}: {count}.", count=len(history.all), file=args.csv)])
    return True
