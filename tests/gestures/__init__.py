"""What hands do at the window, whole and clumsy."""
