"""Editors, sliders and tables."""
