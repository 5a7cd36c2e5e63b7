"""One module of a batch: read, write, verify, enable, check, in one unbroken conversation."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from app.engine.identity import IdentityEvidence
from app.engine.procedure import EngineView, Inspect, Pause, Procedure, ask_report
from app.preflight.evidence import Disturbance, Evidence
from app.preflight.reread import read_state
from app.preflight.run import run_preflight
from app.procedures.settings_reading import is_another
from app.procedures.write_all import SettingChange, WriteContext, WriteReport, write_all
from app.text.messages import UserMessage, message
from protocol.translatable import marked

READINGS = 3
GONE_AFTER = 3
"""Unanswered queries in a row: the module was unplugged."""
POLL_EVERY_S = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class Provisioned:
    """`why`: why nothing was written. `presence`: what tells whether it is still the same module."""

    presence: tuple[int, int]
    why: UserMessage | None = None
    report: WriteReport | None = None
    boot_count: int | None = None


def provision(
    evidence: Evidence, changes: Sequence[SettingChange], context: WriteContext,
    find_known: Callable[[IdentityEvidence], str | None], *, is_enabling: bool,
) -> Procedure[Provisioned]:  # fmt: skip
    """Fill `evidence` after writing `changes`. `find_known`: the module that what was read may be."""
    for _ in range(READINGS):  # it may just have been plugged in
        presence = yield from _presence()
        before = yield from read_state()
        if before.is_complete and presence == (yield from _presence()):
            break
    else:
        return Provisioned(presence=presence, why=message(marked("Cannot be read.")))
    settings, status = before.settings, before.status
    done = Provisioned(presence=presence, boot_count=settings.boot_count)
    if status is None or status.active:
        return replace(done, why=message(marked("The module is ACTIVE: lock it first.")))
    known = find_known(settings.evidence)
    if known is not None:
        text = marked("It may be {module}: boot count and settings fit.")
        return replace(done, why=message(text, module=known))
    report = yield from write_all(changes, context)
    if report.is_fine:
        yield from run_preflight(evidence, is_enabling=is_enabling, journal=context.journal)
    if presence != (yield from _presence()):  # what was written may be in another one
        evidence.disturbance = evidence.disturbance or Disturbance.BROKEN
    return replace(done, report=report)


def await_gone(presence: tuple[int, int]) -> Procedure[None]:
    """Ends when the module stops answering, or has restarted, which may be another one, or another one answers."""
    begin: EngineView = yield Inspect()
    unanswered = 0
    while unanswered < GONE_AFTER:
        report = yield from ask_report()
        unanswered = 0 if report is not None else unanswered + 1
        is_other = report is not None and (yield from is_another(begin))
        if is_other or (yield from _presence())[0] != presence[0]:
            return
        yield Pause(POLL_EVERY_S)


def _presence() -> Procedure[tuple[int, int]]:
    view: EngineView = yield Inspect()
    return view.device.restarts, view.device.breaks
