"""Sessions as files: recorder, reader, library, export."""
