"""The window. Widgets only: no bytes, no files, no rules of the device."""
