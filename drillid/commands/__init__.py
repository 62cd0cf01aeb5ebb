"""The command line: one module for each part of it, which prints what the library's rooms return."""

from drillid.commands.app import app as app
