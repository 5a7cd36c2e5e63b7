"""Reads all readable settings.

    boot count -> every setting, until two answers in a row agree -> boot count

Equal boot counts prove that all values were read without a restart between.
"""

from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple

from app.engine.identity import IdentityEvidence, Trust, evidence_of, is_exchanged, same_module
from app.engine.procedure import EngineView, Inspect, Procedure, Report, TwoModules, is_alive
from app.engine.setting_changes import READABLE_SETTINGS
from app.procedures.handshake import HANDSHAKE_WAITS_S
from app.procedures.who_is_there import Present, who_is_there
from app.procedures.write import read_back, restarted_since
from app.safety.interlocks import Interlock, Refusal
from app.text.messages import message
from protocol.catalogue import BOOT_COUNT
from protocol.fields import Value
from protocol.lag import QUICK_S
from protocol.translatable import marked

REREADINGS = 2
"""After a silence, and after one during the first of them."""
FELL_SILENT = Refusal(Interlock.ONLINE, message(marked("The module does not answer.")))
ANOTHER_ANSWERED = Refusal(Interlock.IS_IDENTITY_SETTLED, message(marked("The module restarted. Read again.")))
"""What was read before is not its, or of two modules."""


class ReadFault(Enum):
    """Why a value is missing; the value is its English, translatable text."""

    NO_REPLY = marked("no reply")
    UNSTEADY = marked("contradictory answers")


class SettingsReading(NamedTuple):
    """Values by key, in the field's unit. `began_at`: monotonic seconds."""

    values: Mapping[str, Value]
    faults: Mapping[str, ReadFault]
    """By key, including the boot count."""
    began_at: float
    boot_count: int | None = None
    """None unless both readings agree."""
    is_restarted: bool = False
    """The module restarted during the reading."""
    is_silent: bool = False
    """The module stopped answering; the rest was not asked for."""

    @property
    def is_complete(self) -> bool:
        """Whether all settings and the boot count were read without a restart."""
        return not self.faults and not self.is_silent and self.boot_count is not None

    @property
    def evidence(self) -> IdentityEvidence:
        return IdentityEvidence(self.boot_count, self.values)


def read_settings() -> Procedure[SettingsReading]:
    """Read all readable settings. Only questions are sent; see `SettingsReading.is_silent` for a silent module."""
    begin: EngineView = yield Inspect()
    values: dict[str, Value] = {}
    faults: dict[str, ReadFault] = {}
    boots: list[int | None] = []
    is_silent = False
    for done, command in enumerate((BOOT_COUNT, *READABLE_SETTINGS, BOOT_COUNT)):
        yield Report(done, len(READABLE_SETTINGS) + 2, marked("Reading: {what}"), (("what", command.title),))
        back = yield from read_back(command)
        if back.raw is None:
            faults[command.key] = ReadFault.UNSTEADY if back.is_unsteady else ReadFault.NO_REPLY
            if not back.is_unsteady and not (yield from is_alive(HANDSHAKE_WAITS_S)):
                is_silent = True
                break
        if command is BOOT_COUNT:
            boots.append(back.raw)
        elif back.raw is not None and command.reply is not None:
            values[command.key] = command.reply.decode(back.raw)
    has_restarted = yield from restarted_since(begin)
    counts = {*boots}
    is_restarted = has_restarted or len(counts - {None}) > 1
    return SettingsReading(
        values=values,
        faults=faults,
        boot_count=counts.pop() if len(boots) == 2 and len(counts) == 1 and not is_restarted else None,
        is_restarted=is_restarted,
        is_silent=is_silent,
        began_at=begin.now,
    )


def read_one_module() -> Procedure[SettingsReading | Refusal]:
    """The settings, read again after a break. Refused where the module falls silent, as what answers later may be
    another one, and where what was read is, or may be, that of two modules."""
    begin: EngineView = yield Inspect()
    try:
        reading = yield from read_settings()
        end: EngineView = yield Inspect()
        is_other = reading.is_restarted or is_refuted(begin, end)
        if not (is_other or reading.is_silent) and end.device.breaks != begin.device.breaks:
            first, reading = reading, (yield from read_settings())
            is_other = reading.is_restarted or same_module(first.evidence, reading.evidence) is Trust.REFUTED
    except TwoModules as error:
        return Refusal(Interlock.AGREES, error.message)
    if reading.is_silent:
        return FELL_SILENT
    return ANOTHER_ANSWERED if is_other else reading


def is_another(begin: EngineView) -> Procedure[bool]:
    """Whether what is read refutes that the module of `begin` answers. After a break it is read again first."""
    for _ in range(REREADINGS):
        if not is_in_doubt(begin, (yield Inspect())):
            break
        yield from read_settings()
    return is_refuted(begin, (yield Inspect()))


class Seen(NamedTuple):
    """Who is there. `is_same`: nothing that was read refutes that it is still the module that it was decided for."""

    present: Present
    is_same: bool


def look(begin: EngineView) -> Procedure[Seen]:
    """Ask who is there, for what was decided for the module of `begin`. Every late answer has passed then."""
    present = yield from who_is_there()
    if is_in_doubt(begin, (yield Inspect())):
        present = yield from who_is_there()  # a silence counts as the line's delay until other questions are answered
        view: EngineView = yield Inspect()
        if view.device.lag_s is None or view.device.lag_s < QUICK_S:  # else a permit would expire meanwhile
            yield from is_another(begin)
            present = yield from who_is_there()
    return Seen(present, not is_refuted(begin, (yield Inspect())))


def is_in_doubt(begin: EngineView, view: EngineView) -> bool:
    """Whether a break made stale what tells that it is the module of `begin`, and no person is asked about it."""
    before, now = evidence_of(begin.device.values, is_fresh=False), evidence_of(view.device.values, is_fresh=True)
    has_count = now.boot_count is not None or before.boot_count is None
    is_stale = not (has_count and before.settings.keys() <= now.settings.keys())
    return view.is_settled and view.device.breaks != begin.device.breaks and is_stale


def is_refuted(begin: EngineView, view: EngineView) -> bool:
    """Without reading anything again; see `is_another`."""
    before = evidence_of(begin.device.values, is_fresh=False)
    read = {key: known for key, known in view.device.values.items() if known.at >= begin.now}
    return view.device.breaks != begin.device.breaks and is_exchanged(before, evidence_of(read, is_fresh=False))
