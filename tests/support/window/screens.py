"""Screens of any size for Qt's offscreen platform."""

import json
from pathlib import Path


def offscreen(folder: Path, width: int, height: int) -> str:
    """What `QT_QPA_PLATFORM` has to be for one screen of so many pixels; written into `folder`."""
    path = folder / f"screen-{width}x{height}.json"
    screen = {"name": "test", "x": 0, "y": 0, "width": width, "height": height,
              "logicalDpi": 96, "logicalBaseDpi": 96, "dpr": 1}  # fmt: skip
    path.write_text(json.dumps({"screens": [screen]}), encoding="utf-8")
    return f"offscreen:configfile={path}"
