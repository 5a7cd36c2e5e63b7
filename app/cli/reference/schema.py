"""`dps-s schema NAME`: prints the JSON Schema of what a command prints with --json, or of a pre-flight record."""

import argparse
import json

from app.cli.results import NAMES, schema_of
from app.terminal import console


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", choices=NAMES, metavar="NAME", help=", ".join(NAMES))


def run(args: argparse.Namespace) -> int:
    console.write(json.dumps(schema_of(args.name), indent=2, ensure_ascii=False) + "\n")
    return console.SUCCESS
