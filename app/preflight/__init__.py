"""Is the module fit to fly, and who says so: the check, its verdict, and a record of it that lasts."""
