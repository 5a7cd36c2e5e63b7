"""Marks texts of constants for translation.

The protocol layer speaks English only and never chooses a language: it hands on English texts, and whoever
shows them translates them.  The mark is what lets ``docs/generate/translations.py`` find them.
"""


def marked(text: str, /) -> str:
    """The text unchanged; its literal goes into the list of texts to translate."""
    return text
