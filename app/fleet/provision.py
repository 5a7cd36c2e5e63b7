"""One module of a batch: read, written, verified, enabled and checked, in one conversation."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from app.engine.conversation import Interrupted
from app.engine.procedure import Pause, Procedure
from app.preflight.evidence import Evidence, StateReading, read_state
from app.preflight.run import run_preflight
from app.procedures.write import SettingChange, WriteContext, WriteReport, why_not_verified, write_all
from app.text.messages import UserMessage, message
from protocol.fields import Value
from protocol.translatable import marked

_LOOK_EVERY_S = 1.0

# The named module that one of this boot count and these settings may be.
FindKnown = Callable[[int, Mapping[str, Value]], str | None]


class Provisioned(NamedTuple):
    """`why` nothing was written, or not everything is as written; None where it was checked."""

    why: UserMessage | None
    boot_count: int | None


def provision(
    evidence: Evidence,
    changes: Sequence[SettingChange],
    context: WriteContext,
    find_known: FindKnown,
    *,
    is_enabling: bool,
) -> Procedure[Provisioned]:
    """Write `changes` and check the module, which fills `evidence`. Raises `Interrupted`: what was written is unknown
    then, and the module that answers next begins from the start."""
    try:
        before = yield from read_state()
        why = _why_not(before, find_known)
        if why is None:
            report = yield from write_all(changes, context)
            if report.interrupted is not None:
                raise report.interrupted
            why = _fault_of(report)
        if why is None:
            yield from run_preflight(evidence, is_enabling=is_enabling, journal=context.journal)
    except Interrupted as error:
        evidence.note_error(error)
        raise
    return Provisioned(why, before.settings.boot_count)


def await_gone() -> Procedure[None]:
    """Wait until the module is unplugged, with its adapter or without, or another one has taken its place."""
    try:
        while True:
            yield Pause(_LOOK_EVERY_S)
    except Interrupted:
        return


def _why_not(before: StateReading, find_known: FindKnown) -> UserMessage | None:
    """Why nothing may be written to this module; None where it may."""
    settings, status = before.settings, before.status
    if not before.is_complete or settings.boot_count is None or status is None:
        return message(marked("Cannot be read."))
    if status.active:
        return message(marked("The module is ACTIVE: lock it first."))
    known = find_known(settings.boot_count, settings.values)
    if known is None:
        return None
    return message(marked("It may be {module}: boot count and settings fit."), module=known)


def _fault_of(report: WriteReport) -> UserMessage | None:
    """The first setting that was not verified; None where all are."""
    if report.is_fine:
        return None
    for written in report.results:
        why = why_not_verified(written, report)
        if why is not None:
            return message(marked("{value}: {why}"), value=message(written.command.title), why=why)
    return message(marked("A setting changed without being written, or could not be read again."))
