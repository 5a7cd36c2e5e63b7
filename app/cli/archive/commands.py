"""`dps-s archive …`: the records of all stations, through a PostgreSQL server or a file.

Exit code 0 done; 1 a chain of checks is broken or altered (status), or there is no such module (report); 2 no such
file, no archive file, or an invalid URL; 3 the server cannot be used; 4 something on the other side was altered or
cannot be read and is left out, or the file cannot be written.
"""

import argparse
from collections.abc import Callable

from app.archive.archive import Archive
from app.archive.chains import ChainState, chains_in
from app.archive.exchange import Exchanged
from app.archive.facts import RefusedFact
from app.archive.module_names import Conflict, Settlement
from app.archive.server_url import server_url, store_server, stored_server
from app.cli.archive import report
from app.cli.archive.opened import member_json, opened_archive, shown_member
from app.cli.commands import SERVER
from app.limits.service import Service, ServiceKind
from app.records.filing import local_now
from app.stations.station import fingerprint_of, shown_station
from app.system.folders import data_folder
from app.terminal import console
from app.text.i18n import tr
from app.text.sentences import labelled
from app.text.user_error import UserError

SHOWN_REFUSALS = 20


def run(args: argparse.Namespace) -> int:
    acts = {
        "sync": run_sync, "export": run_export, "import": run_import, "status": run_status,
        "conflicts": run_conflicts, "settle": run_settle, "report": report.run,
        "service": run_service,
    }  # fmt: skip
    return acts[args.act](args)


def run_status(args: argparse.Namespace) -> int:
    with opened_archive() as archive:
        status = archive.status(stored_server(data_folder()))
        fingerprint = fingerprint_of(archive.station.public)
        stations = {shown_station(key): count for key, count in status.stations.items()}
        chains = chains_in(archive.facts, archive.station)
    is_sound = not any(chain.faults for chain in chains)
    page = [
        *console.columns((
            (tr("Records"), f"{status.facts} ({status.own})"),
            (tr("Stations"), f"{len(stations)}"),
            (tr("Server"), status.place or "–"),
            (tr("Needs decision"), f"{status.conflicts}"),
            (tr("Missing in chains"), f"{sum(chain.missing for chain in chains)}"),
        ), indent=2),
        tr("This station: {fingerprint}", fingerprint=fingerprint),
        tr("Not shared: {count}. Last: {time}.", count=status.not_shared, time=status.last_at or "–"),
        *(f"{shown_station(chain.station)} {chain.module or ''}: {fault.translated()}"
          for chain in chains for fault in chain.faults),
    ]  # fmt: skip
    console.emit(args, status, lambda status: {
        "station": fingerprint, "facts": status.facts, "own": status.own, "stations": stations,
        "server": status.place, "not_shared": status.not_shared, "last_sync_at": status.last_at,
        "conflicts": status.conflicts, "chains": [_chain_json(chain) for chain in chains],
    }, lambda _: page)  # fmt: skip
    return console.SUCCESS if is_sound else console.ANSWER_NO


def run_service(args: argparse.Namespace) -> int:
    """Keep what a person did to a module; print what is due."""
    service = Service(kind=ServiceKind(args.what), on=args.on or local_now().date(), due=args.due, who=args.who,
                      note=args.note)  # fmt: skip
    with opened_archive() as archive:
        archive.collect()
        if not archive.names().named(args.module):
            console.notify(labelled(args.module, tr("none")))
            return console.ANSWER_NO
        archive.keep_service(args.module, service)
    console.write_lines([service.told().translated()])
    return console.SUCCESS


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
    return _exchange(args, "server", shown, lambda archive: archive.sync(url, on_page=_progress), console.NO_LINK)


def run_export(args: argparse.Namespace) -> int:
    return _exchange(
        args, "file", str(args.file), lambda one: one.export(args.file, on_page=_progress), console.PARTIAL
    )


def run_import(args: argparse.Namespace) -> int:
    def import_file(archive: Archive) -> Exchanged:
        return archive.import_file(args.file, on_page=_progress)

    return _exchange(args, "file", str(args.file), import_file, console.USAGE_ERROR)


def _exchange(
    args: argparse.Namespace, key: str, place: str, act: Callable[[Archive], Exchanged], failed: int
) -> int:  # fmt: skip
    with opened_archive() as archive:
        try:
            done = act(archive)
        except UserError as error:
            console.clear_progress()
            raise console.Refused(error.message, failed) from error
    console.clear_progress()
    console.emit(args, done, lambda done: {
        key: place, "sent": done.sent, "received": done.received,
        "refused": [_refused_json(one) for one in done.refused], "refused_count": done.refused_count,
        "damaged": [_refused_json(one) for one in done.damaged],
    }, lambda done: [_counts(done)])  # fmt: skip
    if done.refused_count:
        console.notify(tr("Unreadable or altered, left out: {count}.", count=done.refused_count))
        _notify_refused(done.refused)
    if done.damaged:
        console.notify(tr("Damaged and not sent: {count}.", count=len(done.damaged)))
        _notify_refused(done.damaged)
    return console.SUCCESS if done.is_whole else console.PARTIAL


def run_conflicts(args: argparse.Namespace) -> int:
    with opened_archive() as archive:
        archive.collect()
        conflicts = archive.names().conflicts
    console.emit(args, conflicts, lambda conflicts: {"conflicts": [
        {"kind": conflict.kind.value, "modules": [member_json(module) for module in conflict.pair],
         "proposal": None if conflict.proposal is None else _proposal_json(conflict.proposal)}
        for conflict in conflicts
    ]}, lambda conflicts: [line for conflict in conflicts for line in _question(conflict)])  # fmt: skip
    return console.SUCCESS


def _question(conflict: Conflict) -> tuple[str, str]:
    first, second = map(shown_member, conflict.pair)
    answer = f'  dps-s archive settle "{first}" "{second}" --same|--different --who WHO'
    return conflict.question().translated(), answer


def run_settle(args: argparse.Namespace) -> int:
    with opened_archive() as archive:
        archive.collect()
        members = {shown_member(member): member for module in archive.names().modules for member in module.members}
        one, other = members.get(args.one), members.get(args.other)
        if one is None or other is None:
            raise console.Refused(tr("No such pair of modules in the archive."))
        try:
            archive.settle(one, other, is_same=args.same, name=args.name, who=args.who)
        except UserError as error:
            raise console.Refused(error.message, console.ANSWER_NO) from error
    return console.SUCCESS


def _progress(done: Exchanged) -> None:
    console.show_progress(_counts(done))


def _counts(done: Exchanged) -> str:
    return tr("Sent: {sent}. Received: {received}.", sent=done.sent, received=done.received)


def _chain_json(one: ChainState) -> dict[str, object]:
    return {
        "station": shown_station(one.station), "module": one.module, "audit": one.is_audit, "count": one.count,
        "missing": one.missing, "faults": [fault.in_english() for fault in one.faults],
    }  # fmt: skip


def _proposal_json(proposal: Settlement) -> dict[str, object]:
    return {"station": shown_station(proposal.station), "who": proposal.who, "is_same": proposal.is_same,
            "name": proposal.name}  # fmt: skip


def _refused_json(one: RefusedFact) -> dict[str, object]:
    return {"id": one.id, "kind": one.kind, "made_at": one.made_at, "why": one.why.in_english()}


def _notify_refused(refused: list[RefusedFact]) -> None:
    for one in refused[:SHOWN_REFUSALS]:
        console.notify(f"  {one.sentence().translated()}")
