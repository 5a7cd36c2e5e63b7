"""`dps-s archive …`: the records of all stations, through a PostgreSQL server or a file.

Exit code 0 done; 1 a chain of checks is broken or altered (status), or there is no such module (report); 2 no such
file, no archive file, or an invalid URL; 3 the server cannot be used; 4 something on the other side was altered or
cannot be read and is left out, or the file cannot be written.
"""

import argparse
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from app.archive.archive import Archive
from app.archive.chains import ChainState, chains_in
from app.archive.exchange import Exchanged, export_facts, import_facts, status_of, sync
from app.archive.facts import RefusedFact
from app.archive.fleet_state import CHECK_DAYS, TEST_DAYS, ModuleToday, fleet_state
from app.archive.module_history import ModuleHistory, module_history
from app.archive.module_names import (
    Conflict,
    KnownModule,
    NamedModule,
    Settlement,
    decision_text,
    keep_service,
    names_of,
    settle,
)
from app.archive.server_url import server_url, store_server, stored_server
from app.limits.service import Service, ServiceKind
from app.records.check_store import CheckLine
from app.records.filing import local_now
from app.stations.station import fingerprint_of, shown_station
from app.store.store import open_store
from app.system.files import CANNOT_READ
from app.system.folders import data_folder
from app.system.wall_clock import MINUTE, local_time
from app.terminal import console
from app.terminal.arguments import add_file, add_json, add_module, add_verbosity, any_name, day, module_name, whole_days
from app.text.csv_cells import csv_text, utc_cell
from app.text.i18n import tr
from app.text.sentences import in_brackets, labelled
from app.text.user_error import ErrorCode, UserError
from protocol.translatable import marked

SERVER = "postgresql://USER@HOST/DATABASE"
SHOWN_REFUSALS = 20
FLEET_HEAD = (
    "module", "stations", "last_at", "verdict", "void", "simulated", "check_at", "who", "aircraft",
    "settings_code", "checks", "trigger_records", "not_judged", "due",
    "since_repack",
)  # fmt: skip
LIFE_HEAD = ("at", "station", "kind", "told", "value_name", "value")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    synced = commands.add_parser("sync", help="exchange with a server")
    synced.add_argument("url", nargs="?", metavar="URL", help=SERVER)
    synced.add_argument("--remember", action="store_true", help="remember this server, without its password")
    synced.add_argument("--forget", action="store_true", help="forget the server")
    exported = commands.add_parser("export", help="add to an archive file")
    add_file(exported, "file", type=Path, metavar="FILE")
    imported = commands.add_parser("import", help="import an archive file")
    add_file(imported, "file", type=Path, metavar="FILE")
    status = commands.add_parser("status", help="show what is in the archive")
    conflicts = commands.add_parser("conflicts", help="list possible duplicates")
    settled = commands.add_parser("settle", help="settle whether two modules are one")
    settled.add_argument("one", metavar="STATION/NAME")
    settled.add_argument("other", metavar="STATION/NAME")
    decision = settled.add_mutually_exclusive_group(required=True)
    decision.add_argument("--same", action="store_true")
    decision.add_argument("--different", action="store_true")
    settled.add_argument("--name", default="", metavar="NAME", help="name of both")
    settled.add_argument("--who", required=True, metavar="WHO", help="who decided")
    service = commands.add_parser("service", help="record a service of a module")
    service.add_argument("module", type=module_name, metavar="NAME")
    service.add_argument("--what", choices=("repack", "ejector", "cell", "firmware"), required=True)
    service.add_argument("--on", type=day, metavar="YYYY-MM-DD", help="day on which it was done (default: today)")
    service.add_argument("--due", type=day, metavar="YYYY-MM-DD", help="day on which it is due again")
    service.add_argument("--who", required=True, type=any_name, metavar="WHO", help="who did it")
    service.add_argument("--note", default="", type=any_name, metavar="TEXT", help="note")
    report = commands.add_parser("report", help="print all modules, or one")
    add_module(report, "only this module")
    for name, days in (("--check-days", CHECK_DAYS), ("--test-days", TEST_DAYS)):
        report.add_argument(
            name, type=whole_days, default=days, metavar="N", help=f"due after N days (default: {days})"
        )
    form = report.add_mutually_exclusive_group()
    add_json(form)
    form.add_argument("--csv", action="store_true", help="print a table as CSV")
    for command in (synced, exported, imported, status, conflicts):
        add_json(command)
    runs = {
        synced: run_sync,
        exported: run_export,
        imported: run_import,
        status: run_status,
        conflicts: run_conflicts,
        settled: run_settle,
        service: run_service,
        report: run_report,
    }
    for command, function in runs.items():
        add_verbosity(command)
        command.set_defaults(function=function)


def run(args: argparse.Namespace) -> int:
    code: int = args.function(args)
    return code


@contextmanager
def opened_archive() -> Iterator[Archive]:
    """Raises `UserError` if the records of this computer cannot be read."""
    with closing(open_store()) as store, closing(Archive(store)) as archive:
        for notice in (store.database.notice, archive.others.notice):
            if notice is not None:
                console.notify(notice.translated())
        yield archive


def shown_member(module: NamedModule) -> str:
    return f"{shown_station(module.station)}/{module.name}"


def member_json(module: NamedModule) -> dict[str, object]:
    return {"station": shown_station(module.station), "name": module.name}


def run_status(args: argparse.Namespace) -> int:
    with opened_archive() as archive:
        status = status_of(archive, stored_server(data_folder()))
        count, own = sum(status.stations.values()), status.stations.get(archive.public, 0)
        fingerprint = fingerprint_of(archive.station.public)
        stations = {shown_station(key): facts for key, facts in status.stations.items()}
        chains = chains_in(archive)
    is_sound = not any(chain.faults for chain in chains)
    page = [
        *console.columns((
            (tr("Records"), f"{count}"),
            (tr("Stations"), f"{len(stations)}"),
            (tr("Server"), status.place or "–"),
            (tr("Needs decision"), f"{status.conflicts}"),
            (tr("Missing in chains"), f"{sum(chain.missing for chain in chains)}"),
        ), indent=2),
        tr("This station: {fingerprint}", fingerprint=fingerprint) + in_brackets(labelled(tr("Records"), f"{own}")),
        tr("Not shared: {count}. Last: {time}.", count=status.not_shared, time=local_time(status.last_at or "–")),
        *(f"{shown_station(chain.station)}: {fault.translated()}"
          for chain in chains for fault in chain.faults),
    ]  # fmt: skip
    console.emit(args, {
        "station": fingerprint, "facts": count, "own": own, "stations": stations,
        "server": status.place, "not_shared": status.not_shared, "last_sync_at": status.last_at,
        "conflicts": status.conflicts, "chains": [_chain_json(chain) for chain in chains],
    }, page)  # fmt: skip
    return console.SUCCESS if is_sound else console.ANSWER_NO


def run_service(args: argparse.Namespace) -> int:
    """Keep what a person did to a module; print what is due."""
    service = Service(kind=ServiceKind(args.what), on=args.on or local_now().date(), due=args.due, who=args.who,
                      note=args.note)  # fmt: skip
    with opened_archive() as archive:
        named = names_of(archive).named(args.module)
        if not named:
            console.notify(labelled(args.module, tr("none")))
            return console.ANSWER_NO
        keep_service(archive, min(named, key=partial(_is_farther, archive, args.module)), service)
    console.write_lines([service.summary().translated()])
    return console.SUCCESS


def _is_farther(archive: Archive, name: str, module: KnownModule) -> tuple[bool, bool]:
    """Other stations may use the name for other modules."""
    here = {member.name for member in module.members if member.station == archive.public}
    return name not in here, not here


def run_sync(args: argparse.Namespace) -> int:
    folder = data_folder()
    if args.forget:
        store_server(folder, "")
        return console.SUCCESS
    url = args.url or stored_server(folder)
    if url is None:
        raise console.Refused(tr("No server is set: give {example}.", example=SERVER))
    shown = server_url(url).shown
    if args.remember:
        store_server(folder, url)
    return _exchange(args, "server", shown, partial(sync, url=url), ErrorCode.NO_LINK)


def run_export(args: argparse.Namespace) -> int:
    return _exchange(args, "file", str(args.file), partial(export_facts, path=args.file), ErrorCode.REFUSED)


def run_import(args: argparse.Namespace) -> int:
    return _exchange(args, "file", str(args.file), partial(import_facts, path=args.file), ErrorCode.UNREADABLE)


def _exchange(args: argparse.Namespace, key: str, place: str, act: Callable[..., Exchanged], failed: ErrorCode) -> int:
    with opened_archive() as archive:
        try:
            done = act(archive, on_page=lambda done: console.show_progress(_counts(done)))
        except UserError as error:
            is_no_archive = error.message.text == CANNOT_READ
            raise console.Refused(error.message, ErrorCode.UNREADABLE if is_no_archive else failed) from error
        finally:
            console.clear_progress()
    console.emit(args, {
        key: place, "sent": done.sent, "received": done.received,
        "refused": [_refused_json(fact) for fact in done.refused], "refused_count": done.refused_count,
        "damaged": [_refused_json(fact) for fact in done.damaged],
    }, [_counts(done)])  # fmt: skip
    for text, count, facts in (
        (marked("Left out, unreadable or altered: {count}."), done.refused_count, done.refused),
        (marked("Damaged and not sent: {count}."), len(done.damaged), done.damaged),
    ):
        if count:
            shown = (f"  {fact.sentence().translated()}" for fact in facts[:SHOWN_REFUSALS])
            console.notify("\n".join((tr(text, count=count), *shown)))
    return console.SUCCESS if done.is_whole else console.PARTIAL


def run_conflicts(args: argparse.Namespace) -> int:
    with opened_archive() as archive:
        conflicts = names_of(archive).conflicts
    console.emit(args, {"conflicts": [
        {"kind": conflict.kind.value, "modules": [member_json(module) for module in conflict.pair],
         "proposal": None if conflict.proposal is None else _proposal_json(conflict.proposal)}
        for conflict in conflicts
    ]}, [line for conflict in conflicts for line in _question(conflict)])  # fmt: skip
    return console.SUCCESS


def _question(conflict: Conflict) -> tuple[str, str]:
    first, second = map(shown_member, conflict.pair)
    answer = f'  dps-s archive settle "{first}" "{second}" --same|--different --who WHO'
    return conflict.question().translated(), answer


def run_settle(args: argparse.Namespace) -> int:
    with opened_archive() as archive:
        members = {shown_member(member): member for module in names_of(archive).modules for member in module.members}
        first, second = members.get(args.one), members.get(args.other)
        if first is None or second is None:
            raise console.Refused(tr("No such pair of modules in the archive."))
        try:
            settlement = settle(archive, first, second, is_same=args.same, name=args.name, who=args.who)
        except UserError as error:
            raise console.Refused(error.message, ErrorCode.REFUSED) from error
    console.write_lines([decision_text(settlement).translated()])
    return console.SUCCESS


def _counts(done: Exchanged) -> str:
    return tr("Sent: {sent}. Received: {received}.", sent=done.sent, received=done.received)


def _chain_json(chain: ChainState) -> dict[str, object]:
    return {
        "station": shown_station(chain.station), "count": chain.count,
        "missing": chain.missing, "faults": [fault.in_english() for fault in chain.faults],
    }  # fmt: skip


def _proposal_json(proposal: Settlement) -> dict[str, object]:
    return {"station": shown_station(proposal.station), "who": proposal.who, "is_same": proposal.is_same,
            "name": proposal.name}  # fmt: skip


def _refused_json(fact: RefusedFact) -> dict[str, object]:
    return {"id": fact.id, "kind": fact.kind, "made_at": fact.made_at, "why": fact.why.in_english()}


# The present state of all modules, or the history of one, from all stations


def run_report(args: argparse.Namespace) -> int:
    with opened_archive() as archive:
        names = names_of(archive)
        if args.module is not None:
            lives = [module_history(archive, module) for module in names.named(args.module)]
            if not lives:
                console.notify(labelled(args.module, tr("none")))
                return console.ANSWER_NO
            return _print_histories(args, lives)
        now = datetime.now(UTC)
        states = fleet_state(archive, names, now, check_days=args.check_days, test_days=args.test_days)
    return _print_fleet(args, states, now)


def _print_fleet(args: argparse.Namespace, states: list[ModuleToday], now: datetime) -> int:
    if args.csv:
        console.write(csv_text(FLEET_HEAD, map(_fleet_cells, states)))
        return console.SUCCESS
    at = now.isoformat(timespec="seconds")
    head = (tr("Module"), tr("Last check"), tr("Verdict"), tr("Trigger records"), tr("Due"))
    console.emit(args, {"at": at, "modules": list(map(state_json, states))},
                 console.columns([head, *map(_fleet_row, states)]))  # fmt: skip
    return console.SUCCESS


def _fleet_row(state: ModuleToday) -> tuple[str, ...]:
    check = state.last_check
    at, verdict = (local_time(check.at, MINUTE), check.words.translated()) if check else ("", tr("none"))
    return (state.module.name, at, verdict, state.counted.translated(), state.due_words)


def _print_histories(args: argparse.Namespace, lives: list[ModuleHistory]) -> int:
    if args.csv:
        console.write(csv_text(LIFE_HEAD, (row for life in lives for row in _life_rows(life))))
    else:
        console.emit(args, {"lives": list(map(life_json, lives))},
                     [line for life in lives for line in _life_page(life)])  # fmt: skip
    return console.SUCCESS


def _life_page(life: ModuleHistory) -> list[str]:
    rows = [
        (local_time(event.fact.made_at), shown_station(event.fact.station)[:9], event.text.translated())
        for event in life.events
    ]
    return [life.module.name, *console.columns([(tr("Time"), tr("Station"), ""), *rows])]


def state_json(state: ModuleToday) -> dict[str, object]:
    check = state.last_check
    return {
        "module": state.module.name,
        "members": [member_json(member) for member in state.module.members],
        "last_at": state.last_at or None,
        "last_check": None if check is None else _check_json(check),
        "checks": state.checks,
        "trigger_records": state.trigger_records,
        "not_judged": state.unjudged,
        "since_repack": state.since_repack,
        "tests": [{"test": test.kind.value, "verdict": test.verdict.value, "at": test.at} for test in state.tests],
        "due": [{"kind": due.kind.value, "text": due.text.in_english()} for due in state.due],
    }


def _check_json(check: CheckLine) -> dict[str, object]:
    return {
        "at": check.at, "station": shown_station(check.station), "verdict": check.verdict,
        "void": check.is_void or check.is_fired_since, "simulated": check.is_simulated,
        "who": check.who, "aircraft": check.aircraft, "settings_code": check.code,
    }  # fmt: skip


def life_json(life: ModuleHistory) -> dict[str, object]:
    return {
        "module": life.module.name,
        "members": [member_json(member) for member in life.module.members],
        "events": [
            {"at": event.fact.made_at, "station": shown_station(event.fact.station), "kind": event.fact.kind,
             "id": event.fact.id, "told": event.text.in_english(), "content": dict(event.fact.content)}
            for event in life.events
        ],
        "values": {
            name: [{"at": point.at, "station": shown_station(point.station), "value": point.value} for point in points]
            for name, points in life.values.items()
        },
    }  # fmt: skip


def _fleet_cells(state: ModuleToday) -> Iterable[object]:
    check = state.last_check
    told = state_json(state) | ({} if check is None else _check_json(check))
    told |= {
        "stations": len({member.station for member in state.module.members}),
        "last_at": utc_cell(state.last_at),
        "check_at": None if check is None else utc_cell(check.at),
        "due": state.due_words,
    }
    return map(told.get, FLEET_HEAD)


def _life_rows(life: ModuleHistory) -> Iterable[tuple[object, ...]]:
    for event in life.events:
        station = shown_station(event.fact.station)
        yield utc_cell(event.fact.made_at), station, event.fact.kind, event.text.translated(), None, None
    for name, points in life.values.items():
        for point in points:
            yield utc_cell(point.at), shown_station(point.station), "value", "", name, point.value
