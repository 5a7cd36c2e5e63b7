"""Tables: columns, model, filter and search."""
