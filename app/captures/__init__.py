"""Bytes as files: entries, reader, writer, explanation."""
