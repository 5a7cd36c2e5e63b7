"""The vendor's table of 2019-04-30, typed by hand from the Chinese original. Only the tests here import the product."""
