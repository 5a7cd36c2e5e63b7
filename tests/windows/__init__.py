"""Tests of the program for Windows on a Linux computer, under Wine: `packaging/bootstrap.py windows` runs them."""
