"""`dps-s verify FILE`: was this pre-flight record altered, and who signed it?

FILE is the record (JSON) or the report that carries it (PDF). Exit code 0 if it is intact, whoever signed it; 1 if it
was altered or contradicts itself; 2 if it is no record or cannot be read.
"""

import argparse
from pathlib import Path

import msgspec

from app.archive.archive import known_names
from app.cli.results import VerifyJson
from app.records.verification import RecordState, Verification, shown_key, verify_file
from app.terminal import console
from app.terminal.arguments import add_file, add_json
from app.terminal.command_journal import existing_store, notice_of
from app.text.messages import message
from app.text.sentences import error_text
from app.text.user_error import ErrorCode, UserError
from protocol.translatable import marked

_NO_RECORD = marked("No pre-flight record: {why}.")
_CANNOT_READ = marked("{file} cannot be read: {why}.")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_file(parser, "file", type=Path, metavar="FILE", help="record (.json) or report (.pdf)")
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    store = existing_store()
    names = known_names(store)
    if store is not None:
        notice = notice_of(store)
        if notice is not None:
            console.notify(notice.translated())
        store.close()
    try:
        verification = verify_file(args.file, names)
    except UserError as error:
        raise console.Refused(message(_NO_RECORD, why=error.message), ErrorCode.UNREADABLE) from error
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        text = message(_CANNOT_READ, file=args.file, why=error_text(error))
        raise console.Refused(text, ErrorCode.UNREADABLE) from error
    console.emit(args, result_of(verification), [sentence.translated() for sentence in verification.sentences()])
    return console.SUCCESS if verification.state is RecordState.INTACT else console.ANSWER_NO


def result_of(verification: Verification) -> VerifyJson:
    record, signer = verification.record, verification.signer
    is_signed = verification.state is not RecordState.ALTERED
    names = verification.names.of_key(signer) if is_signed else ()
    others = verification.names.other_keys(signer) if is_signed else {}
    told = {
        "state": verification.state.value,
        "report": verification.is_report,
        "verdict": None if record is None else record.verdict.value,
        "follows": None if record is None else record.follows.value,
        "void": None if record is None else record.void,
        "module": None if record is None else record.module,
        "at": None if record is None else record.at.isoformat(),
        "who": None if record is None else record.who,
        "aircraft": None if record is None else record.aircraft,
        "simulated": None if record is None else record.is_simulated,
        "contradictions": [against.in_english() for against in verification.contradictions],
        "signer": shown_key(signer) if is_signed else None,
        "signed_by": _signed_by(verification) if is_signed else "nobody",
        "names": list(names),
        "other_keys": {name: [shown_key(key) for key in keys] for name, keys in others.items()},
    }
    return msgspec.convert(told, VerifyJson)


def _signed_by(verification: Verification) -> str:
    if verification.is_own:
        return "this_station"
    return "known_station" if verification.names.of_key(verification.signer) else "unknown_key"
