"""Bytes on the line: entries, text, explanation."""
