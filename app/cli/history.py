"""`dps-s history`: reads the trigger records.

The protocol does not tell how many records follow (E6), so they are read until two passes agree. Exit code 0 if they
agree and no frame was lost; 1 if they may not be kept under that name; 2 if the file exists and --force is missing; 3
without a link, or where the conversation ended meanwhile; 4 if they differ, or the query was not answered.
"""

import argparse
from typing import Annotated, Any

from msgspec import Meta

from app.engine.conversation import ConversationView
from app.procedures.history import History
from app.procedures.read import read_settings
from app.store.fact_store import Facts, StoreError
from app.system.files import write_whole
from app.terminal import console
from app.terminal.connection import connected
from app.terminal.records import CommandStore, other_module, refuse_another, say_not_kept, unless_same_module
from app.terminal.results import Byte, Count, Hex, Result
from app.text.csv_cells import csv_text
from app.text.i18n import tr
from app.text.messages import UserMessage, labelled, saved_text
from app.trigger_records.history import (
    FIELDS,
    TriggersReading,
    Visit,
    fields_of,
    file_triggers,
    read_triggers,
    sentence,
)

HEAD = (*FIELDS, "confirmed")


class TriggerRecordJson(Result):
    """`implausible` names the fields that cannot be right; `confirmed`: read twice."""

    boot_count: Byte
    uptime_s: Count
    sources: list[Annotated[str, Meta(pattern="^(serial|attitude|pwm|freefall|bit[0-7])$")]]
    attitude_threshold_deg: float
    freefall_acceleration_g: float
    freefall_time_s: float
    serial_connected: bool
    charging: bool
    light_v: float
    cell_voltage_v: float
    implausible: list[str]
    raw: Hex
    confirmed: bool


class HistoryJson(Result):
    """`answered`: whether the module answered the query at all; `complete`: whether two readings agreed."""

    records: list[TriggerRecordJson]
    empty_slots: Count
    answered: bool
    complete: bool


def add_arguments(parser: argparse.ArgumentParser) -> None:
    form = parser.add_mutually_exclusive_group()
    console.add_flags(form, "--json")
    console.add_file(form, "--csv", metavar="FILE", help="write a table into .csv")
    console.add_flags(parser, "--force")
    console.add_module(parser, "keep the records under this name")


def run(args: argparse.Namespace) -> int:
    if args.csv is not None:
        console.refuse_existing(args.csv, is_forced=args.force)
    with connected(args.port, args.baud) as opened:
        opened.run(read_settings())  # kept with the records, to be shown beside them at the next visit
        reading = opened.run(read_triggers())
    history = reading.history
    # Every record with its fields, and whether it is certain: seen in at least two readings.
    records = [fields_of(record) | {"confirmed": True} for record in history.records]
    records += [fields_of(record) | {"confirmed": False} for record in history.seen_once]
    is_whole = history.is_confirmed
    if args.csv is None:
        listed = [TriggerRecordJson(**dict[str, Any](fields)) for fields in records]
        answer = HistoryJson(listed, history.empty_slots, history.is_answered, history.is_confirmed)
        console.emit(args, answer, page_of(history))
    else:
        table = csv_text(HEAD, ([fields[name] for name in HEAD] for fields in records))
        is_written = console.wrote(args.csv, lambda: write_whole(args.csv, table.encode()))
        # Where it cannot be written no record is lost.
        console.write_lines([saved_text(args.csv, len(history.all))] if is_written else page_of(history))
        is_whole &= is_written
    if not history.is_answered:
        console.notify(labelled(tr("Trigger records"), tr("no reply")))
        return console.PARTIAL
    if not history.is_confirmed:
        console.notify(tr("The readings differ: records may be missing. Read again."))
    if args.module:
        is_whole &= _keep(reading, opened.conversation, args)
    return console.SUCCESS if is_whole else console.PARTIAL


def _keep(reading: TriggersReading, conversation: ConversationView, args: argparse.Namespace) -> bool:
    """Keep the records under the name; whether that could be done. Raises `Refused` where it may be another module."""

    def keep(facts: Facts) -> Visit | UserMessage:
        adapter, is_same = store.where.adapter, args.same_module
        return file_triggers(facts, reading, args.module, port=args.port, adapter=adapter, is_same_module=is_same)

    with CommandStore(args.port) as store:
        refuse_another(conversation, store, args)
        try:
            visit = store.write_in_time(keep)
        except StoreError as trouble:
            say_not_kept(trouble)
            return False
    if isinstance(visit, UserMessage):
        raise unless_same_module(other_module(visit))
    text = tr("{module}: {new} new; records: {count}.", module=args.module, new=visit.new, count=len(visit.records))
    console.note(text)
    return True


def page_of(history: History) -> list[str]:
    """A sentence for each record, in the order in which the module sent them, and remarks."""
    lines = [sentence(record).translated() for record in history.records]
    lines += [f"(?) {sentence(record).translated()}" for record in history.seen_once]
    if not history.all:
        never, unknown = tr("It has never fired, or its memory was cleared."), tr("No answer: the records are unknown.")
        lines = [never if history.is_confirmed else unknown]
    if history.seen_once:
        lines.append(f"(?) {tr('Seen in one reading only. Read again.')}")
    if history.empty_slots:
        lines.append(tr("Empty slots: {count}.", count=history.empty_slots))
    return lines
