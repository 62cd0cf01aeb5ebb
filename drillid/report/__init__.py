"""The fleet's report, one HTML file."""
