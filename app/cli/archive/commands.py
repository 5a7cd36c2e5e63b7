"""`dps-s archive …`: the records of all stations, through a PostgreSQL server or a file.

Exit code 0 done; 1 a chain of checks is broken or altered (status), or there is no such module (report); 2 no such
file, no archive file, or a wrong address; 3 the server cannot be used; 4 done, but something on the other side was
altered and is left out, or the file cannot be written.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.archive.opened import member_json, opened_archive, shown_member, shown_station
from app.cli.archive.report import add_report_parser
from app.terminal.console import (
    DONE,
    NO_LINK,
    PARTLY,
    SAID_NO,
    USED_WRONGLY,
    TableRow,
    add_json_argument,
    as_json,
    end_passing,
    note,
    say,
    say_in_passing,
    two_columns,
    write_lines,
)
from app.text.i18n import tr

if TYPE_CHECKING:
    from app.archive.archive import Archive
    from app.archive.chains import ChainState
    from app.archive.exchange import Exchanged
    from app.archive.facts import RefusedFact

EXAMPLE = "postgresql://USER@HOST/DATABASE"
SHOWN_REFUSALS = 20


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser(
        "archive",
        description=tr(
            "Bring the records of all stations together, on a PostgreSQL server or in a file. "
            "Nothing is sent to a module."
        ),
    )
    acts = parser.add_subparsers(title=tr("commands"), metavar="COMMAND", required=True)
    status = acts.add_parser("status", help=tr("tell what is in the archive and what is not shared yet"))
    add_json_argument(status)
    status.set_defaults(run=run_status)
    sync = acts.add_parser("sync", help=tr("exchange with a server"))
    sync.add_argument("url", nargs="?", metavar="URL",
                      help=tr("{example}; default: the server that is set", example=EXAMPLE))  # fmt: skip
    sync.add_argument("--remember", action="store_true",
                      help=tr("set this server, without its password; the window then uses it"))  # fmt: skip
    sync.add_argument("--forget", action="store_true", help=tr("set no server any more; nothing is exchanged"))
    add_json_argument(sync)
    sync.set_defaults(run=run_sync)
    export = acts.add_parser("export", help=tr("add to a file what it lacks"))
    export.add_argument("file", type=Path, metavar="FILE", help=tr("an archive file; made where there is none"))
    add_json_argument(export)
    export.set_defaults(run=run_export)
    importing = acts.add_parser("import", help=tr("take over from a file what this computer lacks"))
    importing.add_argument("file", type=Path, metavar="FILE", help=tr("an archive file"))
    add_json_argument(importing)
    importing.set_defaults(run=run_import)
    conflicts = acts.add_parser("conflicts", help=tr("list modules that may be the same one"))
    add_json_argument(conflicts)
    conflicts.set_defaults(run=run_conflicts)
    settle = acts.add_parser("settle", help=tr("say whether two modules are the same one"))
    settle.add_argument("one", metavar="STATION/NAME", help=tr("as dps-s archive conflicts prints it"))
    settle.add_argument("other", metavar="STATION/NAME", help=tr("as dps-s archive conflicts prints it"))
    answer = settle.add_mutually_exclusive_group(required=True)
    answer.add_argument("--same", action="store_true", help=tr("they are one module"))
    answer.add_argument("--different", action="store_true", help=tr("they are two modules"))
    settle.add_argument("--name", default="", metavar="NAME", help=tr("what the one module is called"))
    settle.add_argument("--who", default="", metavar="WHO", help=tr("who says so"))
    settle.set_defaults(run=run_settle)
    add_report_parser(acts)


def run_status(args: argparse.Namespace) -> int:
    from app.archive.chains import chains_in
    from app.archive.server_setting import kept_server
    from app.stations.station import fingerprint_of
    from app.store.store import data_folder

    with opened_archive() as archive:
        if archive is None:
            return USED_WRONGLY
        status = archive.status(kept_server(data_folder()))
        fingerprint = fingerprint_of(archive.station.public)
        stations = {shown_station(key): count for key, count in status.stations.items()}
        chains = chains_in(archive.facts)
    is_sound = not any(one.faults for one in chains)
    if args.json:
        write_lines([as_json({
            "station": fingerprint, "facts": status.facts, "own": status.own, "stations": stations,
            "server": status.place, "not_shared": status.not_shared, "last_sync_at": status.last_at,
            "conflicts": status.conflicts, "chains": [_chain_json(one) for one in chains],
        })])  # fmt: skip
        return DONE if is_sound else SAID_NO
    never = tr("never")
    write_lines(two_columns([
        TableRow(tr("This station"), fingerprint),
        TableRow(tr("Records"), tr("{count}, {own} of them of this station", count=status.facts, own=status.own)),
        TableRow(tr("Stations"), f"{len(stations)}"),
        TableRow(tr("Server"), status.place or tr("none set")),
        TableRow(tr("Not yet shared"), f"{status.not_shared}"),
        TableRow(tr("Last exchange"), status.last_at or never),
        TableRow(tr("To be settled"), f"{status.conflicts}"),
        TableRow(tr("Links of chains that are not here yet"), f"{sum(one.missing for one in chains)}"),
    ]))  # fmt: skip
    for chain in chains:
        for fault in chain.faults:
            write_lines([f"{shown_station(chain.station)} {chain.module or ''}: {fault.in_words()}"])
    return DONE if is_sound else SAID_NO


def run_sync(args: argparse.Namespace) -> int:
    from app.archive.fact_set import ArchiveTrouble
    from app.archive.server_setting import keep_server, kept_server
    from app.archive.server_url import server_url
    from app.store.store import data_folder

    folder = data_folder()
    try:
        if args.forget:
            keep_server(folder, "")
            return DONE
        url = args.url or kept_server(folder)
        if url is None:
            say(tr("No server is set: give its address, as in {example}.", example=EXAMPLE))
            return USED_WRONGLY
        shown = server_url(url).shown
        if args.remember:
            keep_server(folder, url)
    except ArchiveTrouble as error:
        say(error.message.in_words())
        return USED_WRONGLY
    return _exchange(args, "server", shown, lambda archive: archive.sync(url, on_page=_progress), NO_LINK)


def run_export(args: argparse.Namespace) -> int:
    return _exchange(args, "file", str(args.file), lambda one: one.export(args.file, on_page=_progress), PARTLY)


def run_import(args: argparse.Namespace) -> int:
    def take_over(archive: "Archive") -> "Exchanged":
        return archive.import_file(args.file, on_page=_progress)

    return _exchange(args, "file", str(args.file), take_over, USED_WRONGLY)


def _exchange(
    args: argparse.Namespace, key: str, place: str, act: "Callable[[Archive], Exchanged]", failed: int
) -> int:  # fmt: skip
    from app.archive.fact_set import ArchiveTrouble

    with opened_archive() as archive:
        if archive is None:
            return USED_WRONGLY
        try:
            done = act(archive)
        except ArchiveTrouble as error:
            end_passing()
            say(error.message.in_words())
            return failed
    end_passing()
    if args.json:
        write_lines([as_json({
            key: place, "sent": done.sent, "received": done.received,
            "refused": [_refused_json(one) for one in done.refused], "refused_count": done.refused_count,
            "damaged": [_refused_json(one) for one in done.damaged],
        })])  # fmt: skip
    else:
        text = tr("Sent: {sent}. Received: {received}.", sent=done.sent, received=done.received)
        write_lines([text])
    if done.refused_count:
        say(tr("Left out, because it is not what a station recorded: {count}.", count=done.refused_count))
        _say_refused(done.refused)
    if done.damaged:
        say(tr("Damaged on this computer and not sent: {count}.", count=len(done.damaged)))
        _say_refused(done.damaged)
    return DONE if done.is_whole else PARTLY


def run_conflicts(args: argparse.Namespace) -> int:
    with opened_archive() as archive:
        if archive is None:
            return USED_WRONGLY
        archive.collect()
        conflicts = archive.names().conflicts
    if args.json:
        write_lines([as_json({"conflicts": [
            {"kind": one.kind.value, "modules": [member_json(module) for module in one.pair]} for one in conflicts
        ]})])  # fmt: skip
        return DONE
    if not conflicts:
        note(tr("Nothing is to be settled."))
    for one in conflicts:
        first, second = map(shown_member, one.pair)
        write_lines([one.question().in_words(), f'  dps-s archive settle "{first}" "{second}" --same|--different'])
    return DONE


def run_settle(args: argparse.Namespace) -> int:
    from app.archive.fact_set import ArchiveTrouble

    with opened_archive() as archive:
        if archive is None:
            return USED_WRONGLY
        archive.collect()
        members = {shown_member(one): one for module in archive.names().modules for one in module.members}
        one, other = members.get(args.one), members.get(args.other)
        if one is None or other is None:
            say(tr("There is no such module in the archive: dps-s archive conflicts prints them."))
            return USED_WRONGLY
        try:
            archive.settle(one, other, is_same=args.same, name=args.name, who=args.who)
        except ArchiveTrouble as error:
            say(error.message.in_words())
            return SAID_NO
    return DONE


def _progress(done: "Exchanged") -> None:
    say_in_passing(tr("Sent: {sent}. Received: {received}.", sent=done.sent, received=done.received))


def _chain_json(one: "ChainState") -> dict[str, object]:
    return {
        "station": shown_station(one.station), "module": one.module, "audit": one.is_audit, "count": one.count,
        "missing": one.missing, "faults": [fault.in_english() for fault in one.faults],
    }  # fmt: skip


def _refused_json(one: "RefusedFact") -> dict[str, object]:
    return {"id": one.id, "kind": one.kind, "made_at": one.made_at, "why": one.why.in_english()}


def _say_refused(refused: "list[RefusedFact]") -> None:
    for one in refused[:SHOWN_REFUSALS]:
        say(f"  {one.sentence().in_words()}")
