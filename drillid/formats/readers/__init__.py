"""Readers, one a format: a module with `SUFFIXES`, `headers` and `read_columns` each."""
