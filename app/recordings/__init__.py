"""Sessions as files: recorder, library, export."""
