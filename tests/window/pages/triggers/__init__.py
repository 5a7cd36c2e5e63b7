"""Tests of ui/pages/triggers/."""
