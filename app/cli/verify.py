"""`dps-s verify FILE`: verifies a pre-flight record; manages the list of known stations.

Takes the record (JSON), the page (HTML) or the report (PDF). Exit code 0 only for what is intact, agrees with itself
and is signed by a station that is known; 1 for less; 2 for what is no record, or no file.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from app.terminal.console import DONE, SAID_NO, USED_WRONGLY, note, say, write_lines
from app.text.i18n import tr
from app.text.sentences import reason_of

if TYPE_CHECKING:
    from app.records.verification import Verification
    from app.stations.known import KnownStation, Stations
    from app.store.store import Store


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser(
        "verify",
        description=tr(
            "Tell whether a pre-flight record was altered, where, who signed it, and whether it agrees with itself. "
            "Exit code 0 only for an intact record signed by a station you know."
        ),
    )
    parser.add_argument("file", type=Path, nargs="?", metavar="FILE",
                        help=tr("the record (.json), its page (.html) or the report (.pdf)"))  # fmt: skip
    parser.add_argument("--trust", metavar="FINGERPRINT",
                        help=tr("believe the station that signed FILE, which has this fingerprint"))  # fmt: skip
    parser.add_argument("--name", default="", metavar="NAME", help=tr("what to call that station"))
    parser.add_argument("--forget", metavar="FINGERPRINT", help=tr("believe this station no longer"))
    parser.add_argument("--stations", action="store_true",
                        help=tr("list this station's fingerprint and those of the stations you know"))  # fmt: skip
    parser.add_argument("--log", action="store_true", help=tr("tell whether the audit log was altered"))
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    from app.stations.known import Stations
    from app.store.store import data_folder

    others = (args.forget is not None, args.stations, args.log)
    if sum((args.file is not None, *others)) != 1 or (args.trust is not None and args.file is None):
        say(tr("Give one of FILE, --stations, --forget and --log; --trust goes with FILE."))
        return USED_WRONGLY
    stations = Stations(data_folder())
    if args.stations:
        return _list(stations)
    if args.forget is not None:
        return _forget(stations, args.forget)
    store = _store()
    try:
        return _log(store) if args.log else _verify(args, stations, store)
    finally:
        if store is not None:
            store.close()


def _verify(args: argparse.Namespace, stations: "Stations", store: "Store | None") -> int:
    from app.archive.chains import ArchivedRecords
    from app.archive.local_facts import find_facts
    from app.records.check_store import CheckStore
    from app.records.verification import RecordState, verify_file
    from app.store.store import data_folder

    facts = find_facts(data_folder())
    kept = ArchivedRecords(facts, CheckStore(store.database) if store is not None else None)
    try:
        verification = verify_file(args.file, kept, stations.find)
        if args.trust is not None:
            if not _trust(stations, verification, args.trust, args.name):
                return SAID_NO
            verification = verify_file(args.file, kept, stations.find)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        why = reason_of(error)
        say(tr("{file} cannot be read: {why}.", file=args.file, why=why))
        return USED_WRONGLY
    finally:
        if facts is not None:
            facts.close()
    write_lines([one.in_words() for one in verification.sentences()])
    if verification.state is RecordState.UNREADABLE:
        return USED_WRONGLY
    return DONE if verification.state is RecordState.INTACT else SAID_NO


def _trust(stations: "Stations", verification: "Verification", fingerprint: str, name: str) -> bool:
    from app.stations.known import is_same_fingerprint
    from app.stations.station import fingerprint_of

    if verification.signer is None or verification.altered:
        say(tr("No station is taken over from it: it is not signed, or was altered."))
        return False
    found = fingerprint_of(verification.signer)
    if not is_same_fingerprint(found, fingerprint):
        say(tr("It is signed by {found}, not by {given}: no station is taken over.", found=found, given=fingerprint))
        return False
    note(tr("Known from now on: {station}.", station=_line(stations.trust(verification.signer, name))))
    return True


def _forget(stations: "Stations", fingerprint: str) -> int:
    found = stations.forget(fingerprint)
    if found is None:
        say(tr("No station that you know has this fingerprint."))
        return SAID_NO
    note(tr("No longer known: {station}.", station=_line(found)))
    return DONE


def _list(stations: "Stations") -> int:
    from app.stations.station import StationTrouble

    try:
        stations.make_own()
    except StationTrouble as trouble:
        say(trouble.sentence)
    write_lines([_line(one) for one in stations.known()])
    return DONE


def _line(station: "KnownStation") -> str:
    return f"{station.fingerprint}  {tr('this computer') if station.is_own else station.name}"


def _log(store: "Store | None") -> int:
    from app.store.audit_chain import check_audit_chain
    from app.store.database import StoreTrouble

    if store is None:
        say(tr("This computer has no audit log."))
        return USED_WRONGLY
    try:
        faults = check_audit_chain(store.database.read)
        count = store.database.read("SELECT count(*) FROM audit")[0][0]
    except StoreTrouble as error:
        say(error.sentence)
        return USED_WRONGLY
    if not faults:
        write_lines([tr("The audit log is unbroken: {count} entries.", count=count)])
        return DONE
    write_lines([tr(one.fault.value, entry=one.entry) for one in faults])
    return SAID_NO


def _store() -> "Store | None":
    """The records of this computer, where it has any; none is made for this."""
    from app.store.database import FILE_NAME, StoreTrouble
    from app.store.store import data_folder, open_store

    if not (data_folder() / FILE_NAME).exists():
        return None
    try:
        store = open_store()
    except StoreTrouble as error:
        say(error.sentence)
        return None
    if store.notice is not None:
        say(store.notice)
    return store
