"""`dps-s verify FILE`: verifies a pre-flight record; manages the list of known stations.

FILE is the record (JSON) or the report that carries it (PDF). Exit code 0 if it is intact, consistent and signed by a
known station; 1 if not; 2 if it is no record or cannot be read.
"""

import argparse
from pathlib import Path

from app.archive.archive import kept_records
from app.records.verification import RecordState, Verification, verify_file
from app.stations.known import KnownStation, Stations, is_same_fingerprint
from app.stations.station import fingerprint_of, own_station
from app.store.database import FILE_NAME
from app.store.store import Store
from app.system.folders import data_folder
from app.terminal import console
from app.terminal.arguments import add_file
from app.terminal.command_journal import closing_store, existing_store
from app.text.i18n import tr
from app.text.sentences import error_text
from app.text.user_error import ErrorCode, UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_file(parser, "file", type=Path, nargs="?", metavar="FILE", help="record (.json) or report (.pdf)")
    parser.add_argument("--trust", metavar="FINGERPRINT", help="trust the station that signed FILE")
    parser.add_argument("--name", default="", metavar="NAME", help="name of that station")
    parser.add_argument("--forget", metavar="FINGERPRINT", help="stop trusting this station")
    parser.add_argument("--revoke", metavar="FINGERPRINT", help="its key is lost or was copied: never trust it")
    parser.add_argument("--stations", action="store_true", help="list known stations")
    parser.add_argument("--log", action="store_true", help="verify the audit log")


def run(args: argparse.Namespace) -> int:
    others = (args.forget is not None, args.revoke is not None, args.stations, args.log)
    if sum((args.file is not None, *others)) != 1 or (args.trust is not None and args.file is None):
        choices = "FILE [--trust FINGERPRINT] | --stations | --forget FINGERPRINT | --revoke FINGERPRINT | --log"
        raise console.Refused(tr("expected {expected}", expected=choices))
    stations = Stations(data_folder())
    if args.stations:
        return _list(stations)
    if args.forget is not None:
        return _change(stations.remove(args.forget))
    if args.revoke is not None:
        return _change(stations.remove(args.revoke, is_revoked=True))
    store = existing_store()
    with closing_store(store):
        return _log(store) if args.log else _verify(args, stations, store)


def _verify(args: argparse.Namespace, stations: Stations, store: Store | None) -> int:
    try:
        with kept_records(store, data_folder()) as kept:
            verification = verify_file(args.file, kept, stations.find)
            if args.trust is not None:
                _trust(stations, verification, args.trust, args.name)
                verification = verify_file(args.file, kept, stations.find)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        text = tr("{file} cannot be read: {why}.", file=args.file, why=error_text(error))
        raise console.Refused(text) from error
    sentences = [sentence.translated() for sentence in verification.sentences()]
    if verification.state is RecordState.UNREADABLE:
        raise console.Refused("\n".join(sentences))  # an error, not an answer
    console.write_lines(sentences)
    return console.SUCCESS if verification.state is RecordState.INTACT else console.ANSWER_NO


def _trust(stations: Stations, verification: Verification, fingerprint: str, name: str) -> None:
    signer = verification.signer
    if signer is None or verification.altered:
        raise console.Refused(tr("Not trusted: it is unsigned or altered."), ErrorCode.REFUSED)
    signed_by = fingerprint_of(signer)
    if not is_same_fingerprint(signed_by, fingerprint):
        text = tr("Not trusted: signed by {found}, not by {given}.", found=signed_by, given=fingerprint)
        raise console.Refused(text, ErrorCode.REFUSED)
    console.note(_line(stations.trust(signer, name)))


def _change(station: KnownStation | None) -> int:
    if station is None:
        raise console.Refused(tr("No trusted station has this fingerprint."), ErrorCode.REFUSED)
    console.note(_line(station))
    return console.SUCCESS


def _list(stations: Stations) -> int:
    try:
        own_station(data_folder())
    except UserError as trouble:
        console.notify(trouble.sentence)
    console.write_lines([_line(station) for station in stations.known()])
    return console.SUCCESS


def _line(station: KnownStation) -> str:
    revoked = f" ({tr('revoked')})" if station.is_revoked else ""
    return f"{station.fingerprint}  {tr('this computer') if station.is_own else station.name}{revoked}"


def _log(store: Store | None) -> int:
    if store is None and (data_folder() / FILE_NAME).exists():
        return console.USAGE_ERROR  # why it cannot be opened is said
    if store is None:
        raise console.Refused(tr("No audit log."))
    faults, count = store.facts.faults(), len(store.audit())
    if not faults:
        console.write_lines([tr("The audit log is intact; entries: {count}.", count=count)])
        return console.SUCCESS
    console.write_lines([fault.message.translated() for fault in faults])
    return console.ANSWER_NO
