"""The simulated module on a pseudo-terminal and on TCP."""
