"""Tests of ui/pages/recordings/."""
