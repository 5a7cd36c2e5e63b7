"""Tables as people have them: the same flight in any dialect is judged the same, or the table is refused.

Five ordinary kinds once gave "would not have fired" although their data show that it would.
"""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from app.flights.judge import TriggerLimits
from app.flights.judging import Answer, FlightSummary
from app.flights.read_log import read_flight_log
from app.flights.table import parse_choice, parse_line
from app.text.messages import UserError

Rows = list[tuple[float, float, float]]
"""Seconds, degrees, g."""
REST: Rows = [(row / 10, 5.0, 1.0) for row in range(80)]
FALL: Rows = [(at_s, tilt, 0.1 if 2 <= at_s < 5 else force) for at_s, tilt, force in REST]
TILT: Rows = [(at_s, 61.5 if at_s >= 3 else tilt, force) for at_s, tilt, force in REST]


def answer(path: Path, *columns: str) -> Answer:
    log = read_flight_log(path, parse_choice(columns) if columns else None)
    return FlightSummary(log).outcome(TriggerLimits()).answer


def refusal(path: Path) -> str:
    with pytest.raises(UserError) as caught:
        read_flight_log(path)
    return str(caught.value)


def written(path: Path, text: str, encoding: str = "utf-8") -> Path:
    path.write_bytes(text.encode(encoding))
    return path


HEAD = "time_s,tilt_deg,acceleration_g"


def table(rows: Rows, head: str = HEAD, cell: str = "{:g}") -> str:
    return "\n".join([head, *(",".join(cell.format(value) for value in row) for row in rows)]) + "\n"


def with_commas(text: str) -> str:
    """As a spreadsheet saves it where numbers have decimal commas."""
    return text.replace(",", ";").replace(".", ",")


DIALECTS: dict[str, Callable[[str], str]] = {
    "plain": str,
    "decimal commas": with_commas,
    "tabs": lambda text: text.replace(",", "\t"),
    "sep= first": lambda text: "sep=;\n" + with_commas(text),
    "comments first": lambda text: "# made by a logger\n#\n\n" + text,
    "units in the second line": lambda text: text.replace("\n", "\ns,deg,g\n", 1),
    "units in brackets": lambda text: text.replace(HEAD, "Time [s],Tilt (°),Acceleration [g]"),
    "quoted": lambda text: "\n".join(
        ",".join(f'"{cell}"' for cell in line.split(",")) for line in text.splitlines()
    ),
    "quoted decimal commas": lambda text: "\n".join(
        ",".join(f'"{cell.replace(".", ",")}"' for cell in line.split(",")) for line in text.splitlines()
    ),
    "Windows lines": lambda text: text.replace("\n", "\r\n"),
    "empty lines between": lambda text: text.replace("\n", "\n\n"),
    "a comma behind each row": lambda text: text.replace("\n", ",\n"),
    "spaces behind commas": lambda text: text.replace(",", ", "),
    "other columns first": lambda text: "\n".join(
        ("note,mode," if line.startswith("time") else "“a, b”;x,3,").replace("“a, b”;x", "ab") + line
        for line in text.splitlines()
    ),
}  # fmt: skip


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.promise("g")
def test_every_dialect_is_judged_alike(tmp_path: Path, dialect: str, encoding: str) -> None:
    answers = [
        answer(written(tmp_path / name, DIALECTS[dialect](table(rows)), encoding))
        for name, rows in (("fall.csv", FALL), ("tilt.txt", TILT), ("rest", REST))
    ]
    assert answers == [Answer.FIRES, Answer.FIRES, Answer.DOES_NOT_FIRE]


class Clock(NamedTuple):
    """A unit of time, and from when it counts."""

    per_s: float
    start_s: float = 0.0


CLOCKS = [Clock(per_s, start_s) for per_s in (1, 1e3, 1e6, 1e9) for start_s in (0, 812.5, 1.75e9)]


@pytest.mark.parametrize("clock", CLOCKS)
@pytest.mark.parametrize("name", ["timestamp", "Time", "t"])
def test_the_unit_of_a_bare_time_is_what_is_plausible_for_a_flight(tmp_path: Path, clock: Clock, name: str) -> None:
    rows = [((at_s + clock.start_s) * clock.per_s, tilt, force) for at_s, tilt, force in FALL]
    text = table(rows, f"{name},tilt_deg,acceleration_g", "{:.15g}" if clock.per_s == 1 else "{:.0f}")
    assert answer(written(tmp_path / "a.csv", text)) is Answer.FIRES


def test_a_unit_that_is_not_certain_is_asked_for_and_the_cure_works_when_typed(tmp_path: Path) -> None:
    head = "time when,roll,pitch,acceleration"
    rows = [(at_s, 0.02, 0.01, force * 9.80665) for at_s, _, force in FALL]
    text = "\n".join([head, *(",".join(f"{value:.4f}" for value in row) for row in rows)])
    path = written(tmp_path / "a.csv", text)
    why = refusal(path)
    assert "No column is known to hold the time." in why
    assert "(columns: time when, roll, pitch, acceleration)" in why
    assert answer(path, "time_s=time when", "roll_rad=roll", "pitch_rad=pitch") is Answer.FIRES
    path = written(tmp_path / "b.csv", text.replace("time when", "time"))
    why = refusal(path)
    assert "The unit of “roll” is not certain." in why
    cure = why.partition("in which unit: ")[2].partition(" (columns:")[0]
    log = read_flight_log(path, parse_line(cure))
    assert FlightSummary(log).outcome(TriggerLimits()).answer is Answer.FIRES


@pytest.mark.parametrize("head", ["a:roll:C,a:pitch:C,load", "tilt of body,load,roll", "a,g,h"])
def test_no_column_is_proposed_for_attitude(tmp_path: Path, head: str) -> None:
    """Whoever types what is proposed would else have the height judged as tilt."""
    text = "\n".join([f"time_s,{head}", *(f"{at_s},1,2,3" for at_s, _, _ in FALL)])
    assert "in which unit: --column tilt_deg=COLUMN (columns:" in refusal(written(tmp_path / "a.csv", text))


def test_a_bare_acceleration_has_the_unit_in_which_an_aircraft_rests(tmp_path: Path) -> None:
    for scale in (1.0, 9.80665):
        rows = [(at_s, tilt, force * scale) for at_s, tilt, force in FALL]
        assert answer(written(tmp_path / "a.csv", table(rows, "time_s,tilt_deg,acceleration"))) is Answer.FIRES


@pytest.mark.parametrize("per_deg", [100.0, np.pi / 0.18])
def test_a_bare_angle_of_more_than_a_turn_is_no_degrees(tmp_path: Path, per_deg: float) -> None:
    """Hundredths of degrees, and thousandths of radians, of which 1073 were taken for a tilt of 7 degrees."""
    rows = [f"{at_s},{round(tilt * per_deg)},0,{force}" for at_s, tilt, force in TILT]
    path = written(tmp_path / "a.csv", "\n".join(["time_s,roll,pitch,acceleration_g", *rows]))
    assert "The unit of “roll” is not certain" in refusal(path)
    with pytest.raises(UserError, match=r"“roll” reaches .*: its unit is another"):
        answer(path, "roll_deg=roll", "pitch_deg=pitch")


@pytest.mark.parametrize("unit", ["time_us", "time_ms"])
def test_a_log_of_implausible_length_is_never_a_no(tmp_path: Path, unit: str) -> None:
    path = written(tmp_path / "a.csv", table(REST, f"{unit},tilt_deg,acceleration_g"))
    assert answer(path) is Answer.NOT_JUDGED
    day = [(at_s * 20_000, tilt, force) for at_s, tilt, force in REST]
    assert answer(written(tmp_path / "b.csv", table(day))) is Answer.NOT_JUDGED


def test_cells_that_are_no_numbers_are_counted_or_the_table_is_refused(tmp_path: Path) -> None:
    rows = [(row / 50, 5.0, 1.0) for row in range(1000)]
    lines = table(rows).splitlines()
    lines[500] = lines[500].replace("5,1", "#N/A,1")
    log = read_flight_log(written(tmp_path / "a.csv", "\n".join(lines)))
    assert [problem.in_english() for problem in log.problems] == [
        "Cells that are no numbers: 1, the first in line 501: “#N/A”."
    ]
    for row in range(501, 515):
        lines[row] = lines[row].replace("5,1", "#N/A,1")
    why = refusal(written(tmp_path / "b.csv", "\n".join(lines)))
    assert why == "Cells that are no numbers: 15, the first in line 501: “#N/A”."


@pytest.mark.parametrize(
    ("cells", "said"),
    [
        (("0", "5,5", "1.5"), "no numbers"),
        (("0", "1,250", "1"), "can be 1.250 or 1250"),
        (("0", "1,5", "1,250.5"), "no numbers"),
        (("0", "1,250.5", "1"), "no numbers"),
        (("0", "5 rad", "1"), "the first in line 2: “5 rad”"),
        (("0", "1", "1", "5"), "Line 2 has 4 cells, the head 3"),
    ],
)
def test_what_can_mean_two_things_is_refused(tmp_path: Path, cells: tuple[str, ...], said: str) -> None:
    rows = [";".join((str(row), *cells[1:])) for row in range(80)]
    assert said in refusal(written(tmp_path / "a.csv", "\n".join([HEAD.replace(",", ";"), *rows])))


def lines(rows: Iterable[Iterable[object]], head: str = HEAD) -> str:
    return "\n".join([head, *(",".join(map(str, row)) for row in rows)])


ARMED = ["Disarmed"] * 10 + ["Armed"] * 70
# Of each sensor rows of its own, and rows without a time.
APART = ((f"{at_s * 1000:.0f},95,0,,,", f"{at_s * 1000:.0f},,,{5.9 * force},0,{7.8 * force}", ",,,,,")
         for at_s, _, force in FALL)  # fmt: skip
FIRING = {
    "ISO times": lines(((f"2026-05-01T12:00:{at_s:04.1f}Z", *row) for at_s, *row in FALL), f"timestamp{HEAD[6:]}"),
    "ISO, apart": lines(((f"2026-05-01 12:00:{at_s:04.1f}", *row) for at_s, *row in FALL), f"timestamp{HEAD[6:]}"),
    "armed": lines(((*row, word) for row, word in zip(FALL, ARMED, strict=True)), f"{HEAD},armed"),
    # As of a logger whose clock is coarser than its rows.
    "the largest of one time": lines(
        (at_s, 62.0 if at_s == 3 and part == 0 else tilt, force) for at_s, tilt, force in REST for part in (0, 1)
    ),
    "a row that is late": lines((*REST[:32], (3.05, 62.0, 1.0), *REST[32:])),
    "empty cells": lines(((row,) for rows in APART for row in rows), "timestamp,roll,pitch,ax,ay,az"),
}


@pytest.mark.parametrize("kind", FIRING)
@pytest.mark.promise("g")
def test_it_fires_also_in_a_table_with(tmp_path: Path, kind: str) -> None:
    path = written(tmp_path / "a.csv", FIRING[kind])
    assert answer(path) is Answer.FIRES
    if kind == "armed":
        assert read_flight_log(path).not_judged_s == pytest.approx(1.0, abs=0.1)


# A counter of microseconds of 32 bits, which begins again.
WRAPPED = [((at_s * 1e6 + 2**32 - 3.5e6) % 2**32, tilt, force) for at_s, tilt, force in FALL]
REFUSED = {
    # The smaller one was left out, and it may be the one that fires.
    "a flight behind another": (table(REST + FALL), "begin again"),
    "a flight before another": (table(FALL + REST), "begin again"),
    "a flight behind a long one": (table(REST * 12 + FALL), "begin again"),
    "a counter": (table(WRAPPED, "timestamp,tilt_deg,acceleration_g", "{:.15g}"), "begin again"),
    "a unit": (table([(at_s, tilt, 3.0) for at_s, tilt, _ in FALL], "time_s,tilt_deg,acceleration"), "is not certain"),
    "a column that is there twice": (lines(((*row, row[1]) for row in REST), f"{HEAD},tilt_deg"), "is there twice."),
}


@pytest.mark.parametrize("kind", REFUSED)
@pytest.mark.promise("g")
def test_what_may_be_judged_wrongly_is_refused(tmp_path: Path, kind: str) -> None:
    text, said = REFUSED[kind]
    assert said in refusal(written(tmp_path / "a.csv", text))


def test_stamps_that_are_coarser_than_a_tilt_prove_nothing(tmp_path: Path) -> None:
    rows = [(np.floor(at_s * 2) / 2, tilt, force) for at_s, tilt, force in REST]
    assert answer(written(tmp_path / "a.csv", table(rows))) is Answer.NOT_JUDGED


def test_a_unit_against_the_line_of_units_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path / "a.csv", table(FALL).replace("\n", "\ns,deg,g\n", 1).replace("time_s", "when"))
    assert answer(path, "time_s=when") is Answer.FIRES
    with pytest.raises(UserError, match="“when” is in s"):
        answer(path, "time_ms=when")


def test_a_remark_between_rows_is_none_and_a_row_that_was_cut_off_is_said(tmp_path: Path) -> None:
    head, *rows = table(FALL).splitlines()
    whole = [head, *rows[:30], "# armed, by hand", *rows[30:]]
    assert read_flight_log(written(tmp_path / "a.csv", "\n".join(whole) + "\n")).problems == ()
    cut = read_flight_log(written(tmp_path / "b.csv", "\n".join(whole) + "\n8.0,5"))
    assert [problem.in_english() for problem in cut.problems] == ["cut off"]
