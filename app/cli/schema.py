"""`dps-s schema NAME`: prints the JSON Schema of what a command prints with --json, or of a pre-flight record."""

import argparse
import json
from importlib import import_module
from typing import Any, Final

import msgspec

from app.terminal import console

# Title, module and structure of each; the module is loaded when its schema is asked for.
SCHEMAS: Final = {
    "act": ("dps-s activate | lock | zero | shutdown --json", "app.cli.act", "ActJson"),
    "archive_module": ("dps-s archive module --json", "app.cli.archive", "ModuleHistoryJson"),
    "archive_report": ("dps-s archive report --json", "app.cli.archive", "ArchiveReportJson"),
    "archive_service": ("dps-s archive service --json", "app.cli.archive", "ServicedJson"),
    "archive_status": ("dps-s archive status --json", "app.cli.archive", "ArchiveStatusJson"),
    "archive_sync": ("dps-s archive sync --json", "app.cli.archive", "SyncJson"),
    "decode": ("dps-s decode --json, one line", "app.cli.decode", "DecodedJson"),
    "deleted": ("dps-s recordings delete --json", "app.cli.recordings", "DeletedJson"),
    "diff": ("dps-s diff --json", "app.cli.diff", "DiffJson"),
    "error": ("in the place of a result, with --json", "app.terminal.results", "ErrorJson"),
    "export": ("dps-s record --json, dps-s recordings export --json", "app.cli.recordings", "ExportJson"),
    "find": ("dps-s find --json", "app.cli.find", "FindJson"),
    "fired": ("dps-s fired --json, one line", "app.cli.fired", "FiredJson"),
    "history": ("dps-s history --json", "app.cli.history", "HistoryJson"),
    "monitor": ("dps-s monitor --json, one line", "app.cli.monitor", "MonitorJson"),
    "ports": ("dps-s ports --json", "app.cli.ports", "PortsJson"),
    "preflight": ("dps-s preflight --json, for one port", "app.cli.preflight", "PreflightJson"),
    "provision": ("dps-s provision --json", "app.cli.provision", "ProvisionJson"),
    "read": ("dps-s read --json", "app.preflight.reading_object", "ReadJson"),
    "record": ("The signed record of a pre-flight check", "app.records.record", "SignedDocument"),
    "recordings": ("dps-s recordings list --json", "app.cli.recordings", "RecordingsJson"),
    "save": ("dps-s save --json", "app.cli.save", "SaveJson"),
    "serve": ("dps-s serve --json, one line", "app.cli.serve", "ServeJson"),
    "set": ("dps-s set --json", "app.cli.set", "SetJson"),
    "verify": ("dps-s verify --json", "app.cli.verify", "VerifyJson"),
}


def schema_of(name: str) -> dict[str, Any]:
    """The JSON Schema of a result. Raises `KeyError` for a name that there is not."""
    title, module, structure = SCHEMAS[name]
    schema = msgspec.json.schema(getattr(import_module(module), structure))
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title, **schema}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", choices=tuple(SCHEMAS), metavar="NAME", help=", ".join(SCHEMAS))


def run(args: argparse.Namespace) -> int:
    console.write(json.dumps(schema_of(args.name), indent=2, ensure_ascii=False) + "\n")
    return console.SUCCESS
