"""Why does it not connect? Causes, evidence, statistics, support bundle."""
