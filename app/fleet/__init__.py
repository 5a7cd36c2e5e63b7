"""Several modules side by side: what each needs next, checks and profiles for all; batches of new ones."""
