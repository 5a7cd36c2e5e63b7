"""Colours, style sheet, icons and shapes."""
