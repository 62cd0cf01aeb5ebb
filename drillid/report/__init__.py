"""The fleet's report: its page and one for each well."""
