"""Tests of `app.guided`."""
