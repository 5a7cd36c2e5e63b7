"""Compares the output, frames and exit code of a command with the states of the module. A finding is a breach.

Two criteria. *Shown*: a value must have been true when the module last reported it, or later. *Proven* ("verified", a
verdict): it must be true when the command ends, except for changes after a final read shortly before the end, which
could not be seen.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final

from app.cli.history import page_of
from app.procedures.history import History
from app.simulator.memory import record_frame
from app.terminal.console import ANSWER_NO, NO_LINK, PARTIAL, SUCCESS
from protocol.fields import Value
from tests.adversary.program import Ran
from tests.support.line.truth import KEYS, Heard, Truth, flag_in, settings_keys

NEAR_S: Final = 1.5
"""A final read must be this recent at the end, so that later changes would have been seen."""
SETTLED_S: Final = 0.5
"""A final read must come this long after the last set, which a module may revert."""
LOOKS_IN_A_ROW: Final = 40
"""Count of answers that a final read of everything may take; it takes longer on a slow line."""
VOLT_STEP: Final = 0.03
NO_RECORDS: Final = page_of(History((), 0, is_confirmed=True))[0]


class Breach(Enum):
    """The kinds of breaches; the value is the heading in the table."""

    WRONG_VALUE = "wrong values shown"
    FALSE_VERIFIED = "false verified"
    FALSE_VERDICT = "false GO or READY"
    LOST_RECORD = "lost records"
    DANGEROUS_FRAME = "frames unasked"
    FALSE_OUTCOME = "false outcomes"
    EXIT_CODE = "dishonest exit codes"
    MISHAP = "errors of its own"
    HANG = "hangs"


@dataclass(frozen=True, slots=True)
class Finding:
    breach: Breach
    text: str


@dataclass(frozen=True, slots=True)
class Case:
    """One run: the command, its result and the recorded truth."""

    ran: Ran
    truth: Truth
    acts: Mapping[bytes, int]
    """Frames that may be sent besides queries, and how often each."""
    latency_s: float
    """Delay that the line adds to a reply."""
    forges: bool
    """The line or the module makes valid frames with wrong contents, so a single answer proves nothing."""
    withholds: bool = False
    """The module leaves a record out, always in the same way."""

    @property
    def answer(self) -> dict[str, Any]:
        """The result on standard output; empty if there is none."""
        lines = self.ran.out.strip().splitlines()
        found = json.loads(lines[-1]) if lines else {}
        return found if isinstance(found, dict) and "error" not in found else {}


Judge = Callable[[Case], Iterator[Finding]]


def judge_all(case: Case, judge: Judge) -> list[Finding]:
    """Check what holds for every command, and what holds for this one."""
    findings = list(conduct(case))
    if not case.ran.is_hung and not case.ran.mishaps:
        try:
            findings += judge(case)
        except (ValueError, KeyError, TypeError, IndexError) as error:
            findings.append(Finding(Breach.MISHAP, f"what it printed cannot be read: {error!r}: {case.ran.out[:200]}"))
    return findings


def conduct(case: Case) -> Iterator[Finding]:
    """Check what holds whatever was asked for."""
    ran = case.ran
    if ran.is_hung:
        yield Finding(Breach.HANG, f"no end after {ran.took_s:.0f} s")
    for mishap in ran.mishaps:
        yield Finding(Breach.MISHAP, repr(mishap))
    if "Traceback" in ran.out + ran.err:
        yield Finding(Breach.MISHAP, "a traceback was printed")
    if not ran.is_hung and not ran.mishaps and ran.code not in (SUCCESS, ANSWER_NO, NO_LINK, PARTIAL):
        yield Finding(Breach.EXIT_CODE, f"exit code {ran.code}")
    allowed = Counter(case.acts)
    for frame, count in case.truth.acts_sent.items():
        if count > allowed[frame]:
            text = f"{frame.hex(' ')} was sent {count} times, asked for {allowed[frame]}"
            yield Finding(Breach.DANGEROUS_FRAME, text)


# Values


def _agrees(key: str, one: object, other: object) -> bool:
    if key == "cell_voltage_v":
        return abs(float(str(one)) - float(str(other))) <= VOLT_STEP
    return one == other


def _was_so(case: Case, key: str, value: object, since: float) -> bool:
    return any(_agrees(key, value, case.truth.value(key, moment)) for moment in case.truth.since(since))


def shown(case: Case, key: str, value: Value) -> Iterator[Finding]:
    """Check a value that is printed as the module's."""
    last = case.truth.last_heard(key)
    if last is None:
        yield Finding(Breach.WRONG_VALUE, f"{key} is shown as {value}, and the module never said it")
    elif not _was_so(case, key, value, last.at - case.latency_s) and not (case.forges and _says(key, last, value)):
        holds = case.truth.value(key, case.truth.now)
        yield Finding(Breach.WRONG_VALUE, f"{key} is shown as {value}, and it is {holds}")


def _says(key: str, heard: Heard, value: object) -> bool:
    """Return whether the reply itself has this value, so that the error cannot be detected."""
    from protocol.catalogue import BY_CODE

    if key in ("active", "triggered"):
        return flag_in(key, heard.raw) is value
    command = next(one for one in BY_CODE.values() if one.key == key)
    return command.reply is not None and _agrees(key, command.reply.decode(heard.raw[4]), value)


def stands(
    case: Case, key: str, value: Value, breach: Breach, said: str, *, settled_s: float = SETTLED_S
) -> Iterator[Finding]:
    """Check a value that is claimed to be proven when the command ends."""
    truth = case.truth
    holds = truth.value(key, truth.now)
    if _agrees(key, value, holds):
        return
    last, changed_at = truth.last_heard(key), truth.changed_at(key)
    if last is not None and changed_at is not None and changed_at > last.at - case.latency_s:
        is_near = truth.ends_at - last.at <= NEAR_S + LOOKS_IN_A_ROW * case.latency_s
        if is_near and last.at >= truth.last_act_at + settled_s:
            return
    since = "all the time" if changed_at is None else f"since {changed_at - truth.ends_at:+.3f} s from the end"
    yield Finding(breach, f"{said}: {key} = {value}, and it is {holds} {since}")


# Commands


def judge_read(case: Case) -> Iterator[Finding]:
    answer, code = case.answer, case.ran.code
    if not answer:
        if code in (SUCCESS, PARTIAL):
            yield Finding(Breach.EXIT_CODE, f"exit code {code}, and nothing was printed")
        return
    values = {**answer["settings"], "boot_count": answer["boot_count"], **answer["status"]}
    missing = [key for key in (*settings_keys(), "boot_count", "active") if values.get(key) is None]
    for key, value in values.items():
        if value is not None and key in (*settings_keys(), "boot_count", "active", "triggered"):
            yield from shown(case, key, value)
    for flag in ("attitude_trigger", "freefall_trigger"):
        if values.get(flag) is not None:
            yield Finding(Breach.WRONG_VALUE, f"{flag} is shown as {values[flag]}, and nobody can know it")
    if code == SUCCESS and (missing or answer["errors"]):
        yield Finding(Breach.EXIT_CODE, f"exit code 0 without {missing or answer['errors']}")
    if code == NO_LINK and not missing:
        yield Finding(Breach.EXIT_CODE, "exit code 3 with everything read")


def judge_set(wanted: Mapping[str, Value]) -> Judge:
    def judge(case: Case) -> Iterator[Finding]:
        answer, code = case.answer, case.ran.code
        results = answer.get("results", {})
        if code == SUCCESS and set(results) != set(wanted):
            yield Finding(Breach.EXIT_CODE, f"exit code 0 with results for {sorted(results)}")
        for key, result in results.items():
            is_fine = result["error"] is None
            if code == SUCCESS and not is_fine:
                yield Finding(Breach.EXIT_CODE, f"exit code 0, and {key}: {result['error']}")
            if result["verified"]:
                yield from stands(case, key, wanted[key], Breach.FALSE_VERIFIED, "verified")
            elif is_fine and key in KEYS and key in settings_keys():
                yield Finding(Breach.FALSE_VERIFIED, f"{key} is neither verified nor wrong")
            elif result["read_back"] is not None and key in settings_keys():
                yield from shown(case, key, result["read_back"])
            if result["acknowledged"] and not _was_acknowledged(case, key):
                yield Finding(Breach.FALSE_VERIFIED, f"{key} is said to be acknowledged, and no answer came")
        if code == SUCCESS or any(result["verified"] for result in results.values()):
            yield from _moved(case, wanted, {*answer.get("changed", {}), *answer.get("unread", [])})

    return judge


def _was_acknowledged(case: Case, key: str) -> bool:
    from protocol.catalogue import BY_CODE

    command = next(one for one in BY_CODE.values() if one.key == key)
    return any(case.truth.heard.get(code) for code in command.reply_codes)


def _moved(case: Case, wanted: Mapping[str, Value], named: set[str]) -> Iterator[Finding]:
    """Check that settings which changed without being written are named."""
    before = case.truth.moments[0]
    for key in settings_keys():
        if key not in wanted and key not in named:
            said = "it is not said to have changed"
            yield from stands(case, key, case.truth.value(key, before), Breach.FALSE_VERIFIED, said)


def judge_baud(wanted: int) -> Judge:
    def judge(case: Case) -> Iterator[Finding]:
        result = case.answer.get("results", {}).get("baud_rate")
        if case.ran.code == SUCCESS and (result is None or not result["verified"]):
            yield Finding(Breach.EXIT_CODE, "exit code 0 without a proven rate")
        if result is not None and result["verified"] and case.truth.now.baud_rate != wanted:
            rate = case.truth.now.baud_rate
            yield Finding(Breach.FALSE_VERIFIED, f"verified: {wanted} baud, and the module is at {rate}")

    return judge


def judge_history(case: Case) -> Iterator[Finding]:
    answer, code = case.answer, case.ran.code
    own = [record_frame(data).hex(" ").upper() for data in case.truth.now.records]
    records = answer.get("records", [])
    listed = [record["raw"].upper() for record in records]
    for raw in sorted(case.truth.records_arrived):
        if raw.hex(" ").upper() not in listed:
            yield Finding(Breach.LOST_RECORD, f"{raw.hex(' ')} arrived and is not listed (exit code {code})")
    invented = Counter(record["raw"].upper() for record in records if record["confirmed"]) - Counter(own)
    if invented:
        yield Finding(Breach.LOST_RECORD, f"listed as certain and never was: {next(iter(invented))}")
    if (code == SUCCESS) != (answer.get("complete") is True):
        yield Finding(Breach.EXIT_CODE, f"exit code {code} with complete: {answer.get('complete')}")
    if code == SUCCESS and not case.withholds and listed != own:
        yield Finding(Breach.LOST_RECORD, f"exit code 0 with {len(listed)} records, and it keeps {len(own)}")
    if NO_RECORDS in case.ran.err + case.ran.out and own:
        yield Finding(Breach.LOST_RECORD, f"said to keep none, and it keeps {len(own)}")


def judge_find(case: Case) -> Iterator[Finding]:
    found, code = case.answer.get("baud_rate"), case.ran.code
    rates = {moment.baud_rate for moment in case.truth.moments}
    if found is not None and found not in rates:
        yield Finding(Breach.WRONG_VALUE, f"found at {found} baud, and it is at {case.truth.now.baud_rate}")
    if (code == SUCCESS) != (found is not None) and case.answer:
        yield Finding(Breach.EXIT_CODE, f"exit code {code} with {found}")


def judge_monitor(case: Case) -> Iterator[Finding]:
    said = {one.raw for one in case.truth.heard.get(0x32, [])}
    known = {(raw[3], raw[4] / 10, bool(raw[5] & 1), bool(raw[6] & 1)) for raw in said}
    lines = [json.loads(line) for line in case.ran.out.splitlines()]
    for line in lines:
        if "error" in line:
            continue
        sample = (line["tilt_deg"], line["acceleration_g"], line["triggered"], line["active"])
        if sample not in known:
            yield Finding(Breach.WRONG_VALUE, f"a status that the module never sent: {sample}")
            break
    if case.ran.code == SUCCESS and not lines:
        yield Finding(Breach.EXIT_CODE, "exit code 0 without a status")


def judge_preflight(case: Case) -> Iterator[Finding]:
    answer, code = case.answer, case.ran.code
    verdict = answer.get("verdict")
    if verdict is None:
        if code == SUCCESS:
            yield Finding(Breach.EXIT_CODE, "exit code 0 without a verdict")
        return
    if (code in (SUCCESS, PARTIAL)) != (verdict in ("GO", "READY")):
        yield Finding(Breach.EXIT_CODE, f"exit code {code} with {verdict}")
    if verdict in ("GO", "READY"):
        against = [one["id"] for one in answer["checks"] if one["result"] not in ("pass", "warn")]
        if against:
            yield Finding(Breach.FALSE_VERDICT, f"{verdict} against {', '.join(against)}")
        yield from _fit(case, verdict, answer["read"], answer["checks"])


def _fit(case: Case, verdict: str, read: Mapping[str, Any], checks: Sequence[Mapping[str, Any]]) -> Iterator[Finding]:
    """Check a verdict that permits flight."""
    truth, now = case.truth, case.truth.now
    values = {**read["settings"], "boot_count": read["boot_count"]}
    for key in (*settings_keys(), "boot_count"):
        if values[key] is None:
            yield Finding(Breach.FALSE_VERDICT, f"{verdict} without {key}")
        else:
            yield from stands(case, key, values[key], Breach.FALSE_VERDICT, verdict)
    yield from stands(case, "active", verdict == "GO", Breach.FALSE_VERDICT, verdict)
    yield from stands(case, "triggered", value=False, breach=Breach.FALSE_VERDICT, said=verdict)
    if now.tilt_deg > MOST_TILT_DEG:
        yield Finding(Breach.FALSE_VERDICT, f"{verdict} at a tilt of {now.tilt_deg}°")
    lost = set(now.records) - {one.raw[4:-1] for one in truth.heard.get(0x35, [])}
    is_said = {check["id"]: check["result"] for check in checks}["trigger_records"] == "warn"  # confirmed by a person
    if lost and not (case.withholds or is_said):
        yield Finding(Breach.FALSE_VERDICT, f"{verdict}, and {len(lost)} trigger records were never seen")
    for flag in ("attitude_trigger", "freefall_trigger"):
        if values[flag] is not True:
            yield Finding(Breach.FALSE_VERDICT, f"{verdict} with {flag} {values[flag]}")


MOST_TILT_DEG: Final = 10


def judge_activation(*, is_wanted: bool) -> Judge:
    def judge(case: Case) -> Iterator[Finding]:
        if case.ran.code == SUCCESS:
            yield from stands(case, "active", is_wanted, Breach.FALSE_OUTCOME, "confirmed", settled_s=0.0)
        if "still reports LOCKED" in case.ran.err + case.ran.out and case.truth.now.is_active:
            yield Finding(Breach.FALSE_OUTCOME, "said to be still locked, and it is active")

    return judge


def judge_zero(case: Case) -> Iterator[Finding]:
    if case.ran.code == SUCCESS and case.truth.now.tilt_deg:
        yield Finding(Breach.FALSE_OUTCOME, f"confirmed, and the tilt is still {case.truth.now.tilt_deg}°")


def judge_shutdown(case: Case) -> Iterator[Finding]:
    if case.ran.code == SUCCESS and case.truth.now.is_on:
        yield Finding(Breach.FALSE_OUTCOME, "confirmed, and the module is still on")
