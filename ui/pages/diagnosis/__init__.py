"""Why it does not connect, statistics, traffic, support bundle."""
