"""Raw logs → one regular series in SI units for each well, with a flag for every repair of a sample."""
