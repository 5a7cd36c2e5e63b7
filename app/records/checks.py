"""Pre-flight checks in the store: kept as signed documents, listed without opening one."""

from collections.abc import Iterable, Sequence
from datetime import datetime, timedelta
from itertools import islice, pairwise
from typing import NamedTuple

from app.preflight.verdict import Verdict, verdict_named
from app.records.record import Record, SignedRecord
from app.store.fact_store import Facts, Kept
from app.store.fired import Fired, all_fired, has_fired_since
from app.store.kinds import PreflightCheck
from app.text.messages import UserMessage, clean, message
from protocol.translatable import marked

# Number of checks that are looked through for an aircraft.
RECENT = 100
LISTED = 200
# A rise by this between two checks is a charge; by less than the other it is none.
CHARGED_V = 0.1
STEADY_V = 0.04
WEEK = timedelta(days=7)


def noted(word: UserMessage, note: str) -> UserMessage:
    """A word with what limits it: English, marked."""
    return message(marked("{tip} ({key})"), tip=word, key=message(note))


class CheckLine(NamedTuple):
    """One check as it is listed. `id`: of its fact, for `document_of`; `at`: ISO 8601 in UTC; `code`: of the settings;
    `station`: the key of who made it; `is_fired_since`: a deploy left or a TRIGGERED was seen after it, so that what it
    said of the module is no longer so."""

    id: str
    at: str
    module: str | None
    verdict: str
    is_void: bool
    is_simulated: bool
    who: str
    aircraft: str
    code: str | None
    cell_voltage_v: float | None
    station: str
    is_fired_since: bool = False

    def after(self, fired: Iterable[Fired]) -> "CheckLine":
        """What is left of it after its module may have fired."""
        return self._replace(is_fired_since=has_fired_since(self.at, fired, simulated=self.is_simulated))

    @property
    def words(self) -> UserMessage:
        """Its verdict and what limits it."""
        word = message(verdict_named(self.verdict).value)
        if self.is_simulated:
            return noted(word, marked("simulated"))
        if self.is_fired_since:
            return noted(word, marked("void: fired since"))
        return noted(word, marked("void")) if self.is_void else word

    @property
    def has_passed(self) -> bool:
        """When it was made; its settings stay approved."""
        return not self.is_void and self.verdict in (Verdict.GO.value, Verdict.READY.value)

    @property
    def holds(self) -> bool:
        return self.has_passed and not self.is_fired_since


def keep_record(facts: Facts, signed: SignedRecord) -> None:
    """Keeps a record: the signed document, and beside it what lists show. Within `Store.write`."""
    record = signed.record
    check = PreflightCheck(
        verdict=record.verdict.value,  # type: ignore[arg-type]
        is_void=record.void is not None,
        is_simulated=record.is_simulated,
        who=record.who,
        aircraft=record.aircraft,
        adapter=record.adapter,
        code=record.settings_code,
        cell_voltage_v=cell_voltage_in(record),
        document=signed.text,
    )
    facts.add(check, record.module, at=record.at)


def cell_voltage_in(record: Record) -> float | None:
    """As it was measured, in volts."""
    measured = [check.measured for check in record.checks if check.id == "cell_voltage"]
    is_number = bool(measured) and isinstance(measured[0], int | float) and not isinstance(measured[0], bool)
    return float(measured[0]) if is_number else None  # type: ignore[arg-type]


def document_of(facts: Facts, id_: str) -> str:
    """Of one check that is listed."""
    check = facts.by_id(PreflightCheck, id_)
    return "" if check is None else check.content.document


def checks_in(facts: Facts, module: str | None = None) -> tuple[CheckLine, ...]:
    """Newest first, of one module (None: modules without a name). Takes up to a millisecond for each: not for the
    window's thread."""
    lines = [check_line(check) for check in islice(facts.back_from_newest(PreflightCheck, module), LISTED)]
    fired = () if module is None else all_fired(facts, module)
    return tuple(line.after(fired) for line in lines)


def aircraft_of(facts: Facts, module: str) -> str:
    """In the last check of this module that names one; else empty."""
    checks = islice(facts.back_from_newest(PreflightCheck, module), RECENT)
    return next((check.content.aircraft for check in checks if check.content.aircraft), "")


def check_line(check: Kept[PreflightCheck]) -> CheckLine:
    content = check.content
    return CheckLine(
        id=check.row.id,
        at=check.at,
        module=check.row.module,
        verdict=content.verdict,
        is_void=content.is_void,
        is_simulated=content.is_simulated,
        who=clean(content.who),
        aircraft=clean(content.aircraft),
        code=content.code,
        cell_voltage_v=content.cell_voltage_v,
        station=check.row.station,
    )


def voltages_of(checks: Sequence[CheckLine]) -> list[tuple[datetime, float]]:
    """The cell's voltage at each check that measured it, from the oldest on."""
    return [
        (datetime.fromisoformat(check.at), check.cell_voltage_v)
        for check in reversed(measuring(checks))
        if check.cell_voltage_v is not None
    ]


def weeks_since_charge(measured: Sequence[tuple[datetime, float]]) -> int | None:
    """How many weeks before the last check the cell was charged last; None where the checks do not tell: they are so
    far apart that a charge is not seen or its week is not known, a rise is too small to be sure, or it was less than a
    week."""
    for (before_at, before_v), (at, volts) in reversed(list(pairwise(measured))):
        if volts - before_v >= CHARGED_V:
            weeks = round((measured[-1][0] - at) / WEEK)
            return weeks if weeks and at - before_at <= WEEK else None
        if volts - before_v > STEADY_V or at - before_at > 2 * WEEK:
            return None
    return None


def measuring(checks: Sequence[CheckLine]) -> list[CheckLine]:
    """Those whose measured values are the module's: of a simulated one only where there is no other."""
    sound = [check for check in checks if not check.is_void]
    return [check for check in sound if not check.is_simulated] or sound
