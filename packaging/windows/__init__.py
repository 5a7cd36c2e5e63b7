"""The installer for Windows; not run here."""
