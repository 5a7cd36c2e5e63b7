"""`dps-s history`: reads the trigger records.

The protocol does not tell how many records follow (E6), so they are read until two passes agree. Exit code 0 if they
agree and no frame was lost; 1 if they may not be kept under that name; 2 if another kind of file would be replaced; 3
without a link; 4 if they differ, the query was not answered, or the conversation ended: what came is listed then, and
nothing is kept.
"""

import argparse
from contextlib import suppress
from pathlib import Path
from typing import Any

from app.cli.results import HistoryJson, TriggerRecordJson
from app.engine.conversation import Interrupted
from app.engine.worker import Batch
from app.limits.out_of_limits import record_outside
from app.procedures.history import History, Pass, history_of
from app.procedures.read import read_settings
from app.system.files import write_whole
from app.terminal import console
from app.terminal.arguments import add_file, add_json, add_module, add_port, add_same_module
from app.terminal.command_journal import records_of
from app.terminal.connection import connected
from app.terminal.export_file import STANDARD_OUTPUT
from app.terminal.module_name import name_given, refuse_another, store_visit
from app.text.csv_cells import csv_text
from app.text.i18n import tr
from app.text.sentences import in_brackets, join_names, labelled, not_written, saved_text
from app.trigger_records.fields import FIELDS, JsonValue, fields_of, source_message
from app.trigger_records.filing import TriggersReading, read_triggers
from app.trigger_records.history import cell_text, uptime_message
from protocol.catalogue import TRIGGER_RECORDS
from protocol.events import Received, Role, Sent
from protocol.messages import EmptySlot, TriggerRecord

HEAD = (*FIELDS, "confirmed")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    form = parser.add_mutually_exclusive_group()
    add_json(form)
    add_file(form, "--csv", type=Path, metavar="FILE", help="write a table into .csv, or - for standard output")
    add_module(parser, "keep the records under this name")
    add_same_module(parser)


def run(args: argparse.Namespace) -> int:
    if args.csv is not None and args.csv.is_file() and not _is_replaceable(args.csv):
        raise console.Refused(tr("{file} exists and is another kind of file.", file=args.csv))
    received = ReceivedRecords()
    reading: TriggersReading | None = None
    ended: Interrupted | None = None
    with connected(args.port, args.baud, on_batch=received.on_batch) as opened:
        try:
            opened.run(read_settings())  # kept with the records, to be shown beside them at the next visit
            reading = opened.run(read_triggers())
        except Interrupted as error:
            ended = error
    history = received.history() if reading is None else reading.history
    if ended is not None and not history.is_answered:
        raise ended
    is_written = _print(history, args)
    if ended is not None:
        console.notify(ended.sentence)
        return console.PARTIAL
    if not history.is_answered:
        console.notify(labelled(tr("Trigger records"), tr("no reply")))
        return console.PARTIAL
    if name_given(args) and reading is not None:
        with records_of(args.port, module=name_given(args)) as records:
            refuse_another(opened, records, args)
            is_written &= store_visit(reading, records, args)
    if not history.is_confirmed:
        console.notify(tr("The readings differ: records may be missing. Read again."))
        return console.PARTIAL
    return console.SUCCESS if is_written else console.PARTIAL


def _is_replaceable(path: Path) -> bool:
    """It is such a table, or empty."""
    head = ",".join(HEAD).encode()
    with suppress(OSError), path.open("rb") as file:
        return file.read(len(head)) in (head, b"")
    return True  # writing it says why


class ReceivedRecords:
    """The records as they came, by pass: the result where the conversation ends meanwhile."""

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
        return history_of([Pass(tuple(messages)) for messages in self._passes])


def _print(history: History, args: argparse.Namespace) -> bool:
    """Print or write the records; whether that succeeded."""
    if args.csv is None:
        console.emit(args, json_of(history), page_of(history))
        return True
    if args.csv == STANDARD_OUTPUT:
        console.write(csv_of(history))
        return True
    try:
        write_whole(args.csv, csv_of(history).encode())
    except OSError as error:
        console.write_lines(page_of(history))  # so that no record is lost
        console.notify(not_written(args.csv, error))
        return False
    console.write_lines([saved_text(args.csv, len(history.all))])
    return True


def json_of(history: History) -> HistoryJson:
    return HistoryJson(
        records=[TriggerRecordJson(**dict[str, Any](fields)) for _, fields in _marked(history)],
        empty_slots=history.empty_slots,
        answered=history.is_answered,
        complete=history.is_confirmed,
    )


def _marked(history: History) -> list[tuple[TriggerRecord, dict[str, JsonValue]]]:
    """Every record with its fields, and whether it is certain: seen in at least two readings."""
    certain = [(record, True) for record in history.records] + [(record, False) for record in history.seen_once]
    return [(record, fields_of(record) | {"confirmed": is_certain}) for record, is_certain in certain]


def csv_of(history: History) -> str:
    return csv_text(HEAD, ([fields[name] for name in HEAD] for _, fields in _marked(history)))


def page_of(history: History) -> list[str]:
    """A table of the records in the order in which the module sent them, and remarks."""
    if not history.all:
        never, unknown = tr("It has never fired, or its memory was cleared."), tr("No answer: the records are unknown.")
        return [never if history.is_confirmed else unknown, *_remarks(history)]
    head = (
        tr("Boot count"), tr("After power-on"), tr("Source"), tr("Attitude"), tr("Free fall"), tr("Serial"),
        tr("Charging"), tr("Light"), tr("Cell voltage"),
    )  # fmt: skip
    rows = [_row(record, is_certain=bool(fields["confirmed"])) for record, fields in _marked(history)]
    return console.columns([head, *rows]) + _remarks(history)


def _row(record: TriggerRecord, *, is_certain: bool) -> tuple[str, ...]:
    return (
        str(record.boot_count) if is_certain else f"{record.boot_count}{in_brackets('?')}",
        uptime_message(record).translated(),
        join_names(source_message(source).translated() for source in record.sources) or tr("unknown"),
        f"{record.attitude_threshold_deg}°",
        f"{record.freefall_acceleration_g:.1f} g, {record.freefall_time_s:.2f} s",
        tr("yes") if record.serial_connected else tr("no"),
        tr("yes") if record.charging else tr("no"),
        f"{record.light_v:.1f} V",
        cell_text(record),
    )


def _remarks(history: History) -> list[str]:
    remarks = []
    if history.seen_once:
        remarks.append(f"(?) {tr('Seen in one reading only. Read again.')}")
    low = next((outside for record in history.all if (outside := record_outside(record)) is not None), None)
    if low is not None:
        remarks.append(f"{in_brackets(tr(low.fault.value)).strip()} < {low.limit}")
    if history.empty_slots:
        remarks.append(tr("Empty slots: {count}.", count=history.empty_slots))
    return ["", *remarks] if remarks else []
