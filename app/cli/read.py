"""`dps-s read`: reads everything once.

Exit code 0; 3 if nothing was read; 4 if something is missing. What was read is also printed when the link is lost.
"""

import argparse

from app.engine.device import STATUS_KEYS, StaleReason
from app.engine.procedure import Inspect, Procedure
from app.procedures.read import Everything, read_everything
from app.terminal import console
from app.terminal.connection import Conversation, LinkTrouble, connected, module_is_silent
from app.terminal.read_report import (
    FELL_SILENT,
    PORT_LOST,
    RESTARTED,
    Findings,
    json_of,
    page_of,
    readable_keys,
    unanswered_reason,
)
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.sentences import join_names

PASSES = 3
"""How often everything is read if the module restarts meanwhile."""


def run(args: argparse.Namespace) -> int:
    with connected(args.port, args.baud) as conversation:
        findings, trouble = _read(conversation, args.port)
    has_something = any(key != "baud_rate" for key in findings.values)
    if has_something or trouble is None or args.json:
        console.write_lines([console.as_json(json_of(findings))] if args.json else page_of(findings))
    if trouble is not None:
        console.notify(trouble)
    elif findings.errors:
        console.notify(
            tr(
                "Could not read: {names}. Read again or check the wiring.",
                names=join_names(findings.errors),
            )
        )
    if trouble is not None and not has_something:
        return console.NO_LINK
    return console.PARTIAL if findings.errors else console.SUCCESS


def _read(conversation: Conversation, port: str) -> tuple[Findings, str | None]:
    """What was read, and a sentence if reading ended early."""
    everything: Everything | None = None
    with LinkTrouble() as link:
        everything = conversation.run(_read_undisturbed())
    if everything is None:
        return _findings(conversation, port, {}, PORT_LOST), link.sentence
    errors = {key: unanswered_reason(unanswered) for key, unanswered in everything.errors.items()}
    if not everything.is_line_dead:
        return _findings(conversation, port, errors, RESTARTED), None
    return _findings(conversation, port, errors, FELL_SILENT), module_is_silent(port, conversation.device)


def _read_undisturbed() -> Procedure[Everything]:
    """Read everything; again if the module restarted meanwhile, since earlier values may be lost."""
    for _ in range(PASSES - 1):
        before = (yield Inspect()).device.restarts
        everything = yield from read_everything()
        if everything.is_line_dead or (yield Inspect()).device.restarts == before:
            return everything
    return (yield from read_everything())


def _findings(
    conversation: Conversation, port: str, errors: dict[str, UserMessage], why_missing: UserMessage
) -> Findings:
    """All values that are known now were read in this conversation.

    `why_missing` is the reason for values that are neither known nor in `errors`.
    """

    known = conversation.device.values
    values = {key: one.value for key, one in known.items() if one.stale_reason is not StaleReason.RESTARTED}
    missing = readable_keys() - set(values)
    blamed = {"status"} if missing & set(STATUS_KEYS) else set()
    blamed |= missing - set(STATUS_KEYS) - {"baud_rate"}
    link = conversation.link
    return Findings(
        port,
        conversation.baud_rate,
        link.round_trip_median_s if link is not None else None,
        values | {"baud_rate": conversation.baud_rate},
        {key: errors.get(key, why_missing) for key in sorted(blamed)},
        link.lag_s if link is not None else None,
        has_damaged=link is not None and link.counters.rejected > 0,
    )
