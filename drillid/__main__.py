"""`python -m drillid`: the command line."""

from drillid.commands import app

if __name__ == "__main__":
    app(prog_name="drillid")
