"""Command mobility → the eight parameters of the transmission line, window by window and jointly."""
