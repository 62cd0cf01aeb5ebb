"""Raw logs → one regular series in SI units for each well, with a flag for whatever was done to a sample."""
