"""Tests of ui/pages/diagnosis/."""
