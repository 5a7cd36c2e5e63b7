"""Compares the readers of flight logs with pyulog and pymavlink, which are installed for this alone."""
