"""Readers, one per format: each a module with `SUFFIXES`, `headers` and `read_columns`."""
