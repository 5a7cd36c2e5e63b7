"""File types that installers register; `dps-s FILE` opens each of them.

The program is the default for its own suffixes only.
"""

from typing import Final, NamedTuple


class FileType(NamedTuple):
    """A type of file. `mime_types`: by suffix, with the dot."""

    key: str
    english: str
    chinese: str
    mime_types: dict[str, str]
    is_own: bool = False
    """No other program uses this suffix."""


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
        "Session or flight log",
        "数据记录或飞行日志",
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
        {".json": "application/json", ".pdf": "application/pdf"},
    ),
)
