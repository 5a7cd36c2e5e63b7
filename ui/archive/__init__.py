"""The archive of all stations: exchange by itself, and a dialog with modules and their histories."""
