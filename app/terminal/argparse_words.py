"""Translates argparse's own messages.

argparse passes its messages to gettext through the names ``_`` and ``ngettext`` of its module, which are replaced here
by functions that call ``tr``.  Messages that are not in the table (of another Python) stay in English.
"""

import argparse
from typing import Final

from app.text.i18n import tr
from protocol.translatable import marked

WORDS: Final = frozenset(
    (
        marked("usage: "),
        marked("positional arguments"),
        marked("options"),
        marked("show this help message and exit"),
        marked("%(prog)s: error: %(message)s\n"),
        marked("argument %(argument_name)s: %(message)s"),
        marked("the following arguments are required: %s"),
        marked("one of the arguments %s is required"),
        marked("unrecognized arguments: %s"),
        marked("expected one argument"),
        marked("expected at least one argument"),
        marked("ignored explicit argument %r"),
        marked("not allowed with argument %s"),
        marked("ambiguous option: %(option)s could match %(matches)s"),
        marked("invalid choice: %(value)r (choose from %(choices)s)"),
        marked("invalid %(type)s value: %(value)r"),
    )
)


def _translated(text: str) -> str:
    return tr(text) if text in WORDS else text


def _translated_count(one: str, many: str, count: int) -> str:
    return _translated(one if count == 1 else many)


def translate_argparse() -> None:
    """Translate the messages of all parsers, into the language in use at that time."""
    setattr(argparse, "_", _translated)  # noqa: B010  mypy knows no such name
    setattr(argparse, "ngettext", _translated_count)  # noqa: B010
