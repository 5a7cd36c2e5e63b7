"""The files that the program opens, as an installer tells the system; `dps-s FILE` takes each of them.

Most endings belong to everybody: there the program is offered beside others. Its own it opens by default.
"""

from typing import Final, NamedTuple


class FileType(NamedTuple):
    """A kind of file. `mime_types`: by ending, with the dot."""

    key: str
    english: str
    chinese: str
    mime_types: dict[str, str]
    is_own: bool = False
    """No other program's files have this ending."""


FILE_TYPES: Final = (
    FileType("Profile", "Profile", "配置文件", {".toml": "application/toml"}),
    FileType("Capture", "DPS-S capture", "DPS-S 抓包文件", {".dpscap": "application/vnd.dps-s.capture"}, is_own=True),
    FileType(
        "CaptureText",
        "Captured bytes as text",
        "文本形式的抓包",
        {".hex": "text/plain", ".txt": "text/plain", ".log": "text/x-log"},
    ),
    FileType(
        "Flight",
        "Flight log or recording",
        "飞行日志或数据记录",
        {
            ".ulg": "application/vnd.px4.ulog",
            ".bin": "application/octet-stream",
            ".csv": "text/csv",
            ".mcap": "application/vnd.mcap",
        },
    ),
    FileType(
        "Record",
        "Pre-flight record",
        "飞行前检查记录",
        {".json": "application/json", ".html": "text/html", ".htm": "text/html", ".pdf": "application/pdf"},
    ),
)
