"""What describes the command line to other programs: completion scripts and JSON Schemas."""
