"""The disk image for macOS; not run here."""
