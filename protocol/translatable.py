"""Marks texts of constants for translation.

The protocol layer returns English texts; whoever shows them translates them. The mark lets
`docs/generate/translations.py` find them.
"""


def marked(text: str, /) -> str:
    """Return the text unchanged; its literal goes into the list of texts to translate."""
    return text
