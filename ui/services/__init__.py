"""What the pages are given, and what is stored for them."""
