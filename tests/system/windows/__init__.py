"""Tests of the program for Windows on a Linux computer, under Wine: `packaging/windows/wine.py package` runs them."""
