"""The embedded demonstration fleet: simulated wells and their raw logs."""
