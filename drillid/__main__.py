"""`python -m drillid`."""

from drillid.command_line import app

if __name__ == "__main__":
    app(prog_name="drillid")
