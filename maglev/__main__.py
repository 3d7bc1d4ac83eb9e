"""`python -m maglev` is the command line `maglev`."""

import sys


def main() -> None:
    """Run the command line; Ctrl-C while it is still being imported is one line, too."""
    try:
        from maglev.cli.app import app
    except KeyboardInterrupt:
        print("maglev: interrupted", file=sys.stderr)
        raise SystemExit(130) from None
    app()


if __name__ == "__main__":
    main()
