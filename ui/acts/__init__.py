"""The controls of dangerous acts: steps, confirmation, hold, ritual, outcome."""
