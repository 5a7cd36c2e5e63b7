"""The record of a pre-flight check: sealed, signed, kept in chains, printed, verified."""
