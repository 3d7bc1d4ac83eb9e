"""`python -m maglev` is the command line `maglev`."""

import sys

from maglev.files.errors import MaglevError
from maglev.files.packages import require_own_packages


def main() -> None:
    """Run the command line; an error while it is imported is one line, too."""
    try:
        require_own_packages()
        from maglev.cli.app import app
    except KeyboardInterrupt:
        print("maglev: interrupted", file=sys.stderr)
        raise SystemExit(130) from None
    except MaglevError as error:
        print(f"maglev: {error}", file=sys.stderr)
        raise SystemExit(2) from None
    app()


if __name__ == "__main__":
    main()
