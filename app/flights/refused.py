"""Files that are dropped by mistake: what each is, and how it becomes something that is read."""

from typing import Final, NamedTuple

from protocol.translatable import marked

READ: Final = marked(
    "Read are PX4 .ulg, ArduPilot .bin and .log, telemetry .tlog, tables .csv and .txt, recordings .mcap, and each of "
    "them in .gz or .zip."
)


class RefusedKind(NamedTuple):
    """A kind of file: how it begins, from which byte on, and what is said."""

    begin: bytes
    offset: int
    text: str


_WEB_PAGE: Final = marked("This is a web page, not a log: download the file itself.")
_DJI: Final = marked("This is a DJI log: convert it to CSV, for example with DatCon.")
_PACKED: Final = marked("This file is packed in a way that is not read: unpack it first.")
_REFUSED: Final = (
    RefusedKind(b"<!doctype html", 0, _WEB_PAGE),
    RefusedKind(b"<html", 0, _WEB_PAGE),
    RefusedKind(
        b"version https://git-lfs", 0,
        marked("This is a Git LFS pointer, not the log: fetch the log with “git lfs pull”."),
    ),
    RefusedKind(
        b"h product:blackbox", 0,
        marked("This is a Betaflight or INAV blackbox log: convert it to CSV with “blackbox_decode --simulate-imu”."),
    ),
    RefusedKind(b"build", 16, _DJI),
    RefusedKind(b"logh", 0, _DJI),
    RefusedKind(b"#rosbag", 0, marked("This is a ROS bag: export its topics as CSV.")),
    RefusedKind(b"<?xml", 0, marked("This is XML, such as a KML or GPX track: it has no attitude. Export a CSV.")),
    RefusedKind(b"{", 0, marked("This is JSON: convert it to CSV.")),
    RefusedKind(b"%pdf", 0, marked("This is a PDF, not a log.")),
    RefusedKind(b"7z\xbc\xaf\x27\x1c", 0, _PACKED),
    RefusedKind(b"rar!", 0, _PACKED),
    RefusedKind(b"\xfd7zxz", 0, _PACKED),
    RefusedKind(b"bzh", 0, _PACKED),
    RefusedKind(b"\x28\xb5\x2f\xfd", 0, _PACKED),
    RefusedKind(b"\xd0\xcf\x11\xe0", 0, marked("This is a spreadsheet or document: save it as CSV.")),
)  # fmt: skip
_BY_SUFFIX: Final = {
    ".bbl": _REFUSED[3].text, ".bfl": _REFUSED[3].text, ".dat": _DJI,
}  # fmt: skip
SPREADSHEET: Final = marked("This is a spreadsheet: save it as CSV.")


def why_refused(start: bytes) -> str | None:
    """What is said of a file that begins so, in English, marked; None where it may be a log."""
    begin = start.removeprefix(b"\xef\xbb\xbf").lstrip().lower()
    for kind in _REFUSED:
        found = start.lower() if kind.offset else begin
        if found[kind.offset :].startswith(kind.begin):
            return kind.text
    return None


def why_unknown(suffix: str) -> str | None:
    """What is said of bytes that nobody knows, by the ending of the file's name."""
    return _BY_SUFFIX.get(suffix.lower())
