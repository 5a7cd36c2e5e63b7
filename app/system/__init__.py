"""The computer: atomic files, log files, clocks."""
