"""The figures of a well as PNG files."""
