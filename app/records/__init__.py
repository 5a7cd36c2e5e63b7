"""The record of a pre-flight check: signed, kept, printed, verified."""
