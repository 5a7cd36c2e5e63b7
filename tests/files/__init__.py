"""Tests of what the program keeps and reads: store, archive, records, recordings, flight logs."""
