"""JSON objects out of files that anybody may have written."""

import json
from typing import Any


def object_in(text: Any) -> dict[str, Any]:
    """The JSON object in a text or in bytes, empty if there is none."""
    try:
        value = json.loads(text)
    except (ValueError, TypeError, RecursionError):
        return {}
    return value if isinstance(value, dict) else {}
