"""The computer: atomic files, log files, sleep detection, wall clock."""
