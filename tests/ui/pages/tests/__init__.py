"""Tests of `ui.pages.tests`."""
