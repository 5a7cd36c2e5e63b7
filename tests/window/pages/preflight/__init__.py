"""Tests of ui/pages/preflight/."""
