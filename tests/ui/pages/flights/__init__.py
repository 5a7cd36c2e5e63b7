"""Tests of ui/pages/flights/."""
