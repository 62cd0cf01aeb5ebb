"""Mutated log files of every format through reader, record and windows: only errors of drillid may come of them."""
