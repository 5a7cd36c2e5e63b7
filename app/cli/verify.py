"""`dps-s verify FILE`: was this pre-flight record altered, and who signed it?

FILE is the record (JSON) or the report that carries it (PDF). Exit code 0 if it is intact, whoever signed it; 1 if it
was altered or contradicts itself; 2 if it is no record or cannot be read.
"""

import argparse
from pathlib import Path
from typing import Any, Literal

import msgspec

from app.archive.archive import known_names
from app.records.verification import RecordState, Verification, shown_key, verify_file
from app.terminal import console
from app.terminal.arguments import add_file, add_json
from app.terminal.records import existing_store, notice_of
from app.terminal.results import Result, Time
from app.text.messages import message
from app.text.sentences import error_text
from app.text.user_error import ErrorCode, UserError
from protocol.translatable import marked


class VerifyJson(Result):
    """`report`: the file is a report, in which only the record is signed. `follows`: the verdict that the checks give.
    `signer`: fingerprint of the key; `names`: what stations with it call themselves, `other_keys`: who else calls
    himself so. What an altered file says is null where it cannot be read."""

    state: Literal["intact", "contradictory", "altered"]
    report: bool
    verdict: Literal["GO", "READY", "NO-GO"] | None
    follows: Literal["GO", "READY", "NO-GO"] | None
    void: str | None
    module: str | None
    at: Time | None
    who: str | None
    aircraft: str | None
    simulated: bool | None
    contradictions: list[str]
    signer: str | None
    signed_by: Literal["this_station", "known_station", "unknown_key", "nobody"]
    names: list[str]
    other_keys: dict[str, list[str]]


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
        text = message(marked("No pre-flight record: {why}."), why=error.message)
        raise console.Refused(text, ErrorCode.UNREADABLE) from error
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        text = message(marked("{file} cannot be read: {why}."), file=args.file, why=error_text(error))
        raise console.Refused(text, ErrorCode.UNREADABLE) from error
    console.emit(args, result_of(verification), [sentence.translated() for sentence in verification.sentences()])
    return console.SUCCESS if verification.state is RecordState.INTACT else console.ANSWER_NO


def result_of(verification: Verification) -> VerifyJson:
    record, names = verification.record, verification.names
    found: dict[str, Any] = dict.fromkeys(VerifyJson.__struct_fields__)
    found["state"] = verification.state.value
    found["report"] = verification.is_report
    found["contradictions"] = [against.in_english() for against in verification.contradictions]
    if record is not None:
        found |= {name: getattr(record, name) for name in ("verdict", "follows", "void", "module", "who", "aircraft")}
        found["at"] = record.at.isoformat()
        found["simulated"] = record.is_simulated
    found["signed_by"], found["names"], found["other_keys"] = "nobody", [], {}
    if verification.state is not RecordState.ALTERED:
        signer = verification.signer
        found["signer"] = shown_key(signer)
        found["names"] = list(names.of_key(signer))
        found["other_keys"] = {name: list(map(shown_key, keys)) for name, keys in names.other_keys(signer).items()}
        known = "known_station" if found["names"] else "unknown_key"
        found["signed_by"] = "this_station" if verification.is_own else known
    return msgspec.convert(msgspec.to_builtins(found), VerifyJson)
