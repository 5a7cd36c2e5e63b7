"""A capture file looked over before it is read: what it is, how long it lasts; and lines that are longer than any."""

import io
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.captures import survey as capture_survey
from app.captures.entries import CaptureEntry, Way
from app.captures.reader import OpenCapture
from app.captures.survey import ENTRY_LINE, MAGIC_LINE, MAX_LINE_LENGTH, CaptureProbe
from app.captures.writer import Header
from tests.support.records.captures import ENTRIES, STATUS_FRAME, read_capture, written

LINES = st.sampled_from(
    [
        "41 75",
        "# DPS-S capture 1",
        " # a DPS-S capture 1",
        "1.5 < 41",
        "2.25 > 42 61",
        "< 41",
        "",
        "0.5<41",
        "# < >",
        "zz",
    ]
)


def surveyed(text: bytes, block_bytes: int) -> CaptureProbe:
    survey = CaptureProbe()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(capture_survey, "_BLOCK_BYTES", block_bytes)
        for _ in survey.steps(io.BytesIO(text)):
            pass
    return survey


@given(st.lists(LINES), st.sampled_from(["\n", "\r\n", "\r"]), st.integers(1, 40))
def test_it_tells_hex_text_from_a_capture_as_reading_every_line_does(
    lines: list[str], line_end: str, block_bytes: int
) -> None:
    is_plain = not any(MAGIC_LINE.fullmatch(line.strip()) or ENTRY_LINE.fullmatch(line.strip()) for line in lines)
    assert surveyed(line_end.join(lines).encode(), block_bytes).is_plain is is_plain


@given(st.lists(st.lists(st.integers(0, 10**6), min_size=1, max_size=5), min_size=1, max_size=4), st.integers(20, 400))
def test_it_knows_how_long_a_capture_of_several_parts_lasts(parts: list[list[int]], block_bytes: int) -> None:
    text = "".join(
        "".join(f"{line}\n" for line in Header(port="p").lines())
        + "".join(f"{at / 1000:.3f} < 41 75\n" for at in sorted(part))
        for part in parts
    )
    assert surveyed(text.encode(), block_bytes).duration_s == pytest.approx(sum(max(part) for part in parts) / 1000)


def test_hex_text_lasts_as_long_as_its_bytes() -> None:
    assert surveyed(b"41 75 32 07\n" * 1440, 100).duration_s == pytest.approx(1440 * 4 * 10 / 115200)


def test_reading_goes_in_small_steps(tmp_path: Path) -> None:
    """So that whoever reads can stop, or let others work, between two of them."""
    path = tmp_path / "a"
    written(path, [CaptureEntry(number / 100, Way.IN, STATUS_FRAME) for number in range(5000)])
    with path.open("rb") as file:
        opened = OpenCapture(file)
        steps = list(opened.steps())
        assert opened.expected_s == pytest.approx(49.99)
        assert opened.share_read == 1.0
    assert max(map(len, steps)) < 200
    assert sum(map(len, steps)) == 5000
    assert steps[0] == []  # it was looked over, and is not yet read


def test_a_file_of_which_nothing_is_read_is_left_in_small_steps_too(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("# DPS-S capture 1\n" + "?\n" * 100_000, encoding="utf-8")
    with (tmp_path / "a").open("rb") as file:
        opened = OpenCapture(file)
        assert sum(1 for _ in opened.steps()) > 40


def long_lines() -> Iterator[tuple[str, list[int], bytes]]:
    frames = STATUS_FRAME.hex(" ") + " "
    many = MAX_LINE_LENGTH // len(frames) * 3
    yield frames * many, [], STATUS_FRAME * many
    yield f"{frames * many}\n{frames}\n", [], STATUS_FRAME * (many + 1)
    yield f"# {frames * many}\n{frames}\n", [], STATUS_FRAME
    yield f"{' ' * 2 * MAX_LINE_LENGTH}4\n{frames}", [1], STATUS_FRAME
    yield f"{' ' * 2 * MAX_LINE_LENGTH}zz{frames * many}\n{frames}", [1], STATUS_FRAME


@pytest.mark.parametrize(
    ("text", "faults", "raw"), list(long_lines()), ids=["alone", "first", "remark", "half a byte", "no hex"]
)
def test_a_line_of_hex_text_may_be_endless(tmp_path: Path, text: str, faults: list[int], raw: bytes) -> None:
    (tmp_path / "a").write_text(text, encoding="utf-8")
    capture = read_capture(tmp_path / "a")
    assert [fault.line for fault in capture.faults] == faults
    assert b"".join(entry.raw for entry in capture.entries) == raw


def test_an_endless_line_of_a_capture_is_one_fault(tmp_path: Path) -> None:
    path = tmp_path / "a"
    written(path)
    with path.open("a") as file:
        file.write(f"4000.0 < {'41 75 ' * MAX_LINE_LENGTH}\n# {'x' * 3 * MAX_LINE_LENGTH}\n4001.0 < 41\n")
    capture = read_capture(path)
    first = len(path.read_text(encoding="utf-8").splitlines()) - 2
    assert [(fault.line, fault.text) for fault in capture.faults] == [(first, "the line is too long")]
    assert capture.entries == (*ENTRIES, CaptureEntry(4001.0, Way.IN, b"A"))
