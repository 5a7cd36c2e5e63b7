"""Prints reports as the program does."""

from app.modules.labels import A4
from ui.files.report_printer import print_pages


def print_report(body: str, attachment: bytes) -> bytes:
    return print_pages([body], A4, attachment)
