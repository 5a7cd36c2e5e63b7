"""`dps-s archive …`: the records of all stations, through a PostgreSQL server or a file.

Exit code 0 done; 1 there is no such module; 2 no archive file, or an invalid address; 3 the server cannot be used;
4 done, but rows that were altered or cannot be read were left out.
"""

import argparse
from datetime import UTC, date, datetime
from functools import partial
from typing import Any

from msgspec import field

from app.archive.archive import status_of, sync
from app.archive.report import HistoryEvent, module_history, report
from app.modules.service import service_summary, serviced
from app.records.filing import local_now
from app.store.fact_store import Store
from app.store.rows import ServiceKind
from app.store.station import shown_key
from app.system.clock import MINUTE, local_time
from app.terminal import console
from app.terminal.records import CommandStore
from app.terminal.results import Count, Result, Time
from app.text.csv_cells import csv_text
from app.text.i18n import tr
from app.text.messages import ErrorCode, labelled
from protocol.translatable import marked

SERVER = "postgresql://USER@HOST/DATABASE"
REPORT_HEAD = (
    *("module", "last_at", "verdict", "void", "simulated", "check_at", "who", "aircraft"),
    *("checks", "trigger_records", "not_judged", "due"),
)


class ArchiveCheckJson(Result):
    at: Time
    verdict: str
    void: bool
    is_simulated: bool = field(name="simulated")
    who: str
    aircraft: str


class ArchiveModuleJson(Result, tag_field="kind", tag="module"):
    """`due`: sentences; also of contradictions, as if two modules had this name."""

    name: str = field(name="module")
    last_at: Time | None
    last_check: ArchiveCheckJson | None
    checks: Count
    trigger_records: Count
    unjudged: Count = field(name="not_judged")
    due: list[str]


class ArchiveReportJson(Result, tag_field="kind", tag="report"):
    at: Time
    modules: list[ArchiveModuleJson]


class ArchiveEventJson(Result):
    """`content`: of the fact, by its kind."""

    at: Time
    station: str
    kind: str
    id: str
    told: str
    content: dict[str, Any]


class ModuleHistoryJson(Result, tag_field="kind", tag="history"):
    module: str
    events: list[ArchiveEventJson]


class ServicedJson(Result):
    module: str
    told: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    add = partial(console.add_command, commands)
    synced = add(run_sync, "sync", "exchange with a server or a file, in both directions")
    synced.add_argument("place", nargs="?", metavar="URL|FILE", help=f"{SERVER}; default: as set in the window")
    add(run_status, "status", "show what is in the archive")
    module = add(run_module, "module", "print the history of a module")
    service = add(run_service, "service", "record a service of a module")
    for command in (module, service):
        command.add_argument("module", type=console.name, metavar="NAME")
    day = dict[str, Any](type=date.fromisoformat, metavar="YYYY-MM-DD")
    service.add_argument("--what", choices=[kind.value for kind in ServiceKind], required=True)
    service.add_argument("--on", help="day on which it was done (default: today)", **day)
    service.add_argument("--due", help="day on which it is due again", **day)
    service.add_argument("--who", required=True, metavar="WHO", help="who did it")
    service.add_argument("--note", default="", metavar="TEXT", help="note")
    reported = add(run_report, "report", "print all modules")
    reported.form.add_argument("--csv", action="store_true", help="print a table as CSV")


def run(args: argparse.Namespace) -> int:
    with CommandStore() as store:
        return int(args.function(args, store))


def run_status(args: argparse.Namespace, store: Store) -> int:
    status = status_of(store)
    page = [
        labelled(tr("Records"), status.facts),
        labelled(tr("Stations"), len(status.stations)),
        labelled(tr("Server"), status.server or "–"),
        tr("This station: {fingerprint}", fingerprint=status.station),
    ]
    if status.server is not None:  # of no other place it is told
        last_at = local_time(status.last_sync_at or "–")
        page.append(tr("Not shared: {count}. Last: {time}.", count=status.not_shared, time=last_at))
    ahead = marked("{station} wrote with a clock that is ahead: that counts for nothing.")
    page += [tr(ahead, station=station) for station in status.stations_ahead]
    return console.emit(args, status, page)


def run_sync(args: argparse.Namespace, store: Store) -> int:
    address = args.place or store.state("server")
    if address is None:
        raise console.Refused(tr("No server is set: give {example}.", example=SERVER))
    done = sync(store, address)
    console.emit(args, done, [tr("Sent: {sent}. Received: {received}.", sent=done.sent, received=done.received)])
    if not done.left_out_count:
        return console.SUCCESS
    named = (f"  {one.id}: {one.why}" for one in done.left_out)
    console.notify("\n".join((tr("Left out, unreadable or altered: {count}.", count=done.left_out_count), *named)))
    return console.PARTIAL


def run_report(args: argparse.Namespace, store: Store) -> int:
    now = datetime.now(UTC)
    answer, cells = ArchiveReportJson(now.isoformat(timespec="seconds"), []), list[tuple[object, ...]]()
    page = [(tr("Module"), tr("Last check"), tr("Verdict"), tr("Trigger records"), tr("Due"))]
    for state in report(store, now):
        check, last_check = state.last_check, None
        # In UTC, as spreadsheets know it.
        of_check: tuple[object, ...] = (None,) * 6
        if check is not None:
            last_check = ArchiveCheckJson.of(check, void=check.is_void or check.is_fired_since)
            outcome = (check.verdict, last_check.void, check.is_simulated)
            of_check = (*outcome, local_time(check.at, zone=UTC), check.who, check.aircraft)
        due = [due.in_english() for due in state.due]
        answer.modules.append(
            ArchiveModuleJson.of(state, last_at=state.last_at or None, last_check=last_check, due=due)
        )
        counts = (state.checks, state.trigger_records, state.unjudged)
        cells.append((state.name, local_time(state.last_at, zone=UTC), *of_check, *counts, state.due_words))
        at = "" if check is None else local_time(check.at, MINUTE)
        verdict = tr("none") if check is None else check.words.translated()
        page.append((state.name, at, verdict, str(state.trigger_records), state.due_words))
    if not args.csv:
        return console.emit(args, answer, console.columns(page))
    console.write(csv_text(REPORT_HEAD, cells))
    return console.SUCCESS


def run_module(args: argparse.Namespace, store: Store) -> int:
    answer, page = ModuleHistoryJson(args.module, []), list[tuple[str, ...]]()
    for event in _history(store, args.module):
        row, station = event.row, shown_key(event.row.station)
        told = ArchiveEventJson(row.made_at, station, row.kind, row.id, event.text.in_english(), event.content)
        answer.events.append(told)
        page.append((local_time(row.made_at), station[:9], event.text.translated()))
    return console.emit(args, answer, [args.module, *console.columns(page)])


def run_service(args: argparse.Namespace, store: Store) -> int:
    on = args.on or local_now().date()
    content = serviced(ServiceKind(args.what), on=on, due=args.due, who=args.who, note=args.note)
    # A mistyped name must not become another module.
    _history(store, args.module)
    store.write_in_time(lambda facts: facts.add(content, args.module))
    told = service_summary(content)
    return console.emit(args, ServicedJson(args.module, told.in_english()), [told.translated()])


def _history(store: Store, module: str) -> list[HistoryEvent]:
    """Raises `Refused` where no station knows a module of this name."""
    events = module_history(store, module)
    if not events:
        raise console.Refused(labelled(module, tr("none")), ErrorCode.REFUSED)
    return events
