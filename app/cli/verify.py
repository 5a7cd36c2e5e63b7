"""`dps-s verify FILE`: was this pre-flight record altered, and who signed it?

FILE is the record (JSON) or the report that carries it (PDF). Exit code 0 if it is intact, whoever signed it; 1 if it
was altered or contradicts itself; 2 if it is no record or cannot be read.
"""

import argparse
from datetime import datetime
from typing import Annotated, Literal

from msgspec import Meta, field

from app.archive.archive import known_names
from app.preflight.verdict import Verdict
from app.records.verification import RecordState, verify_file
from app.store.station import shown_key
from app.terminal import console
from app.terminal.records import CommandStore
from app.terminal.results import Result
from app.text.messages import ErrorCode, UserError, message
from protocol.translatable import marked


class VerifyJson(Result):
    """`report`: the file is a report, in which only the record is signed. `follows`: the verdict that the checks give.
    `signer`: fingerprint of the key; `names`: what stations with it call themselves. What an altered file says
    is null."""

    state: RecordState
    report: bool
    contradictions: list[str]
    signed_by: Literal["this_station", "known_station", "unknown_key", "nobody"]
    names: list[str]
    signer: str | None
    verdict: Verdict | None = None
    follows: Verdict | None = None
    void: str | None = None
    module: str | None = None
    at: Annotated[datetime, Meta(tz=True)] | None = None
    who: str | None = None
    aircraft: str | None = None
    is_simulated: bool | None = field(default=None, name="simulated")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    console.add_file(parser, "file", metavar="FILE", help="record (.json) or report (.pdf)")


def run(args: argparse.Namespace) -> int:
    with CommandStore() as store:
        names = known_names(store)
    try:
        found = verify_file(args.file, names)
    except UserError as error:
        text = message(marked("No pre-flight record: {why}."), why=error.message)
        raise console.Refused(text, ErrorCode.UNREADABLE) from error
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        raise console.unreadable(args.file, error) from error
    is_altered = found.state is RecordState.ALTERED
    # Of an altered file nobody is the signer, whatever key it names.
    signers = [] if is_altered else found.names.of_key(found.signer)
    signed_by = "known_station" if signers else "unknown_key"
    if is_altered or found.is_own:
        signed_by = "nobody" if is_altered else "this_station"
    answer = VerifyJson.of(
        found.record,
        state=found.state,
        report=found.is_report,
        contradictions=[against.in_english() for against in found.contradictions],
        signed_by=signed_by,
        names=signers,
        signer=None if is_altered else shown_key(found.signer),
    )
    page = [sentence.translated() for sentence in found.sentences()]
    code = console.SUCCESS if found.state is RecordState.INTACT else console.ANSWER_NO
    return console.emit(args, answer, page, code)
