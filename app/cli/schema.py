"""`dps-s schema NAME`: prints the JSON Schema of what a command prints with --json, or of a pre-flight record."""

import argparse
import json
from importlib import import_module
from typing import Any, Final

import msgspec

from app.terminal import console

# Module and structure of each, by command, or by what it prints; the module is loaded when its schema is asked for.
_OF_COMMANDS: Final = (
    *("decode", "diff", "find", "fired", "history", "monitor", "ports", "preflight", "provision", "recordings"),
    *("save", "serve", "set", "verify"),
)
_OTHERS: Final = {
    "act": ("app.cli.act", "ActJson"),
    "archive_module": ("app.cli.archive", "ModuleHistoryJson"),
    "archive_report": ("app.cli.archive", "ArchiveReportJson"),
    "archive_service": ("app.cli.archive", "ServicedJson"),
    "archive_status": ("app.archive.archive", "ArchiveStatus"),
    "archive_sync": ("app.archive.archive", "Synced"),
    "deleted": ("app.cli.recordings", "DeletedJson"),
    "error": ("app.terminal.results", "ErrorJson"),
    "export": ("app.cli.recordings", "ExportJson"),
    "read": ("app.preflight.reading_object", "ReadJson"),
    "record": ("app.records.record", "SignedDocument"),
}
_NAMED: Final = {name: (f"app.cli.{name}", f"{name.capitalize()}Json") for name in _OF_COMMANDS}
SCHEMAS: Final = dict(sorted((_NAMED | _OTHERS).items()))


def schema_of(name: str) -> dict[str, Any]:
    """The JSON Schema of a result; of what is printed line by line, that of a line. Raises `KeyError`."""
    module, structure = SCHEMAS[name]
    # msgspec names neither the dialect nor the document.
    schema = msgspec.json.schema(getattr(import_module(module), structure))
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": name, **schema}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", choices=tuple(SCHEMAS), metavar="NAME", help=", ".join(SCHEMAS))


def run(args: argparse.Namespace) -> int:
    console.write(json.dumps(schema_of(args.name), indent=2, ensure_ascii=False) + "\n")
    return console.SUCCESS
