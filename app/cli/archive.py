"""`dps-s archive …`: the records of all stations, through a PostgreSQL server or a file.

Exit code 0 done; 1 there is no such module; 2 no archive file, or an invalid address; 3 the server cannot be used;
4 done, but rows that were altered or cannot be read were left out.
"""

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime

from app.archive.archive import Archive
from app.archive.module_history import HistoryEvent, module_history
from app.archive.postgres import is_server, server_url, store_server, stored_server
from app.archive.report import CHECK_DAYS, TEST_DAYS, ModuleToday, report
from app.archive.sync import Synced, sync
from app.cli.results import (
    ArchiveCheckJson,
    ArchiveDueJson,
    ArchiveEventJson,
    ArchiveModuleJson,
    ArchiveReportJson,
    ArchiveStationJson,
    ArchiveStatusJson,
    ArchiveTestJson,
    LeftOutJson,
    ModuleHistoryJson,
    ServicedJson,
    SyncJson,
)
from app.modules.service import ServiceKind, service_summary, serviced
from app.records.checks import CheckLine
from app.records.filing import local_now
from app.stations.station import fingerprint_of
from app.store.fact_store import Store
from app.store.kinds import Serviced
from app.system.folders import data_folder
from app.system.wall_clock import MINUTE, local_time
from app.terminal import console
from app.terminal.arguments import add_json, add_verbosity, any_name, day, module_name, whole_days
from app.terminal.command_journal import opened_store
from app.text.csv_cells import csv_text, utc_cell
from app.text.i18n import tr
from app.text.sentences import in_brackets, labelled
from app.text.user_error import ErrorCode

SERVER = "postgresql://USER@HOST/DATABASE"
REPORT_HEAD = (
    "module", "last_at", "verdict", "void", "simulated", "check_at", "who", "aircraft", "settings_code",
    "checks", "trigger_records", "not_judged", "due",
)  # fmt: skip
HISTORY_HEAD = ("at", "station", "kind", "told", "cell_voltage_v")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    synced = commands.add_parser("sync", help="exchange with a server or a file, in both directions")
    synced.add_argument("place", nargs="?", metavar="URL|FILE", help=f"{SERVER} (default: the remembered server)")
    synced.add_argument("--remember", action="store_true", help="remember this server, without its password")
    synced.add_argument("--forget", action="store_true", help="forget the server")
    status = commands.add_parser("status", help="show what is in the archive")
    history = commands.add_parser("module", help="print the history of a module")
    history.add_argument("module", type=module_name, metavar="NAME")
    service = commands.add_parser("service", help="record a service of a module")
    service.add_argument("module", type=module_name, metavar="NAME")
    service.add_argument("--what", choices=("repack", "ejector", "cell", "firmware"), required=True)
    service.add_argument("--on", type=day, metavar="YYYY-MM-DD", help="day on which it was done (default: today)")
    service.add_argument("--due", type=day, metavar="YYYY-MM-DD", help="day on which it is due again")
    service.add_argument("--who", required=True, type=any_name, metavar="WHO", help="who did it")
    service.add_argument("--note", default="", type=any_name, metavar="TEXT", help="note")
    reported = commands.add_parser("report", help="print all modules")
    for name, days in (("--check-days", CHECK_DAYS), ("--test-days", TEST_DAYS)):
        reported.add_argument(
            name, type=whole_days, default=days, metavar="N", help=f"due after N days (default: {days})"
        )
    for command in (history, reported):
        form = command.add_mutually_exclusive_group()
        add_json(form)
        form.add_argument("--csv", action="store_true", help="print a table as CSV")
    for command in (synced, status, service):
        add_json(command)
    runs = {synced: run_sync, status: run_status, history: run_module, service: run_service, reported: run_report}
    for command, function in runs.items():
        add_verbosity(command)
        command.set_defaults(function=function)


def run(args: argparse.Namespace) -> int:
    code: int = args.function(args)
    return code


@contextmanager
def opened_archive() -> Iterator[Archive]:
    """Raises `UserError` if the records of this computer cannot be read."""
    with opened_store() as (store, _troubles):
        yield Archive(store)


def run_status(args: argparse.Namespace) -> int:
    place = stored_server(data_folder())
    with opened_archive() as archive:
        status = archive.status()
        exchanged = archive.exchanged(place or "")
        own = archive.store.station
    stations = [ArchiveStationJson(station=_shown(key), name=name) for key, name in sorted(status.stations.items())]
    answer = ArchiveStatusJson(
        station=_shown(own),
        facts=status.facts,
        own=status.own,
        stations=stations,
        server=place,
        not_shared=exchanged.not_shared,
        last_sync_at=exchanged.last_at,
        stations_ahead=[_shown(key) for key in status.ahead],
    )
    page = [
        *console.columns((
            (tr("Records"), f"{status.facts}"),
            (tr("Stations"), f"{len(stations)}"),
            (tr("Server"), place or "–"),
        ), indent=2),
        tr("This station: {fingerprint}", fingerprint=_shown(own))
        + in_brackets(labelled(tr("Records"), f"{status.own}")),
        tr("Not shared: {count}. Last: {time}.",
           count=exchanged.not_shared, time=local_time(exchanged.last_at or "–")),
        *(tr("{station} wrote with a clock that is ahead: that counts for nothing.", station=_shown(key))
          for key in status.ahead),
    ]  # fmt: skip
    console.emit(args, answer, page)
    return console.SUCCESS


def run_sync(args: argparse.Namespace) -> int:
    """Both directions."""
    folder = data_folder()
    if args.forget:
        store_server(folder, "")
        return console.SUCCESS
    address = args.place or stored_server(folder)
    if address is None:
        raise console.Refused(tr("No server is set: give {example}.", example=SERVER))
    shown = server_url(address).shown if is_server(address) else address
    if args.remember:
        store_server(folder, address)
    with opened_archive() as archive:
        try:
            done = sync(archive, address, on_page=lambda done: console.show_progress(_counts(done)))
        finally:
            console.clear_progress()
    left_out = [LeftOutJson(id=one.id, why=one.why) for one in done.left_out]
    answer = SyncJson(
        place=shown,
        sent=done.sent,
        received=done.received,
        left_out=left_out,
        left_out_count=done.left_out_count,
    )
    console.emit(args, answer, [_counts(done)])
    if not done.left_out_count:
        return console.SUCCESS
    named = (f"  {one.id}: {one.why}" for one in done.left_out)
    console.notify("\n".join((tr("Left out, unreadable or altered: {count}.", count=done.left_out_count), *named)))
    return console.PARTIAL


def run_report(args: argparse.Namespace) -> int:
    now = datetime.now(UTC)
    with opened_archive() as archive:
        modules = report(archive, now, check_days=args.check_days, test_days=args.test_days)
    if args.csv:
        console.write(csv_text(REPORT_HEAD, [_report_cells(state) for state in modules]))
        return console.SUCCESS
    answer = ArchiveReportJson(at=now.isoformat(timespec="seconds"), modules=[_module_json(state) for state in modules])
    head = (tr("Module"), tr("Last check"), tr("Verdict"), tr("Trigger records"), tr("Due"))
    console.emit(args, answer, console.columns([head, *map(_report_row, modules)]))
    return console.SUCCESS


def run_module(args: argparse.Namespace) -> int:
    """The history of one module."""
    with opened_archive() as archive:
        events = module_history(archive, args.module)
    if not events:
        raise console.Refused(labelled(args.module, tr("none")), ErrorCode.REFUSED)
    if args.csv:
        console.write(csv_text(HISTORY_HEAD, _history_rows(events)))
        return console.SUCCESS
    rows = [(local_time(event.row.made_at), _shown(event.row.station)[:9], event.text.translated()) for event in events]
    page = [args.module, *console.columns([(tr("Time"), tr("Station"), ""), *rows])]
    answer = ModuleHistoryJson(module=args.module, events=[_event_json(event) for event in events])
    console.emit(args, answer, page)
    return console.SUCCESS


def run_service(args: argparse.Namespace) -> int:
    """Keep what a person did to a module; print what is due."""
    on = args.on or local_now().date()
    content = serviced(ServiceKind(args.what), on=on, due=args.due, who=args.who, note=args.note)
    with opened_archive() as archive:
        if args.module not in archive.read(lambda facts: facts.modules()):
            raise console.Refused(labelled(args.module, tr("none")), ErrorCode.REFUSED)
        keep_service(archive.store, args.module, content)
    told = service_summary(content)
    console.emit(args, ServicedJson(module=args.module, told=told.in_english()), [told.translated()])
    return console.SUCCESS


def keep_service(store: Store, module: str, content: Serviced) -> None:
    """Raises `StoreTrouble`."""
    store.add(content, module).result()


def _shown(key: str) -> str:
    return fingerprint_of(bytes.fromhex(key))


def _counts(done: Synced) -> str:
    return tr("Sent: {sent}. Received: {received}.", sent=done.sent, received=done.received)


def _report_row(state: ModuleToday) -> tuple[str, ...]:
    check = state.last_check
    at, verdict = (local_time(check.at, MINUTE), check.words.translated()) if check else ("", tr("none"))
    return (state.name, at, verdict, str(state.trigger_records), state.due_words)


def _module_json(state: ModuleToday) -> ArchiveModuleJson:
    return ArchiveModuleJson(
        module=state.name,
        last_at=state.last_at or None,
        last_check=None if state.last_check is None else _check_json(state.last_check),
        checks=state.checks,
        trigger_records=state.trigger_records,
        not_judged=state.unjudged,
        tests=[ArchiveTestJson(test=test.kind.value, verdict=test.verdict.value, at=test.at) for test in state.tests],
        due=[ArchiveDueJson(kind=due.kind, text=due.text.in_english()) for due in state.due],
        two_modules=[text.in_english() for text in state.two_modules],
    )


def _check_json(check: CheckLine) -> ArchiveCheckJson:
    return ArchiveCheckJson(
        at=check.at,
        station=_shown(check.station),
        verdict=check.verdict,
        void=check.is_void or check.is_fired_since,
        simulated=check.is_simulated,
        who=check.who,
        aircraft=check.aircraft,
        settings_code=check.code,
    )


def _report_cells(state: ModuleToday) -> tuple[object, ...]:
    check = state.last_check
    void = check is not None and (check.is_void or check.is_fired_since)
    return (
        state.name,
        utc_cell(state.last_at),
        None if check is None else check.verdict,
        void,
        None if check is None else check.is_simulated,
        None if check is None else utc_cell(check.at),
        None if check is None else check.who,
        None if check is None else check.aircraft,
        None if check is None else check.code,
        state.checks,
        state.trigger_records,
        state.unjudged,
        state.due_words,
    )


def _event_json(event: HistoryEvent) -> ArchiveEventJson:
    return ArchiveEventJson(
        at=event.row.made_at,
        station=_shown(event.row.station),
        kind=event.row.kind,
        id=event.row.id,
        told=event.text.in_english(),
        content=event.content,
    )


def _history_rows(events: Sequence[HistoryEvent]) -> Iterator[tuple[object, ...]]:
    for event in events:
        row = event.row
        voltage = event.content.get("cell_voltage_v")
        yield utc_cell(row.made_at), _shown(row.station), row.kind, event.text.translated(), voltage
