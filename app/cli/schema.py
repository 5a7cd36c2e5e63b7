"""`dps-s schema NAME`: prints the JSON Schema of what a command prints with --json, or of a pre-flight record."""

import argparse
import json
from importlib import import_module
from typing import Any, Final

import msgspec

from app.terminal import console

# Module and structure of each, by command, or by what it prints; the module is loaded when its schema is asked for.
SCHEMAS: Final = {
    "act": ("app.cli.act", "ActJson"),
    "archive_module": ("app.cli.archive", "ModuleHistoryJson"),
    "archive_report": ("app.cli.archive", "ArchiveReportJson"),
    "archive_service": ("app.cli.archive", "ServicedJson"),
    "archive_status": ("app.archive.archive", "ArchiveStatus"),
    "archive_sync": ("app.archive.archive", "Synced"),
    "decode": ("app.cli.decode", "DecodedJson"),
    "deleted": ("app.cli.recordings", "DeletedJson"),
    "diff": ("app.cli.diff", "DiffJson"),
    "error": ("app.terminal.results", "ErrorJson"),
    "export": ("app.cli.recordings", "ExportJson"),
    "find": ("app.cli.find", "FindJson"),
    "fired": ("app.cli.fired", "FiredJson"),
    "history": ("app.cli.history", "HistoryJson"),
    "monitor": ("app.cli.monitor", "MonitorJson"),
    "ports": ("app.cli.ports", "PortsJson"),
    "preflight": ("app.cli.preflight", "PreflightJson"),
    "provision": ("app.cli.provision", "ProvisionJson"),
    "read": ("app.preflight.reading_object", "ReadJson"),
    "record": ("app.records.record", "SignedDocument"),
    "recordings": ("app.cli.recordings", "RecordingsJson"),
    "save": ("app.cli.save", "SaveJson"),
    "serve": ("app.cli.serve", "ServeJson"),
    "set": ("app.cli.set", "SetJson"),
    "verify": ("app.cli.verify", "VerifyJson"),
}


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
