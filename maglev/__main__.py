"""`python -m maglev` is the command line `maglev`."""

from maglev.cli.app import app

if __name__ == "__main__":
    app()
