"""The module's trigger records: fields, merged history, sentences."""
