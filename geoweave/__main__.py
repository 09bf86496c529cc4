"""``python -m geoweave``."""

import sys


def run() -> int:
    """Run the command; also while it is imported, Ctrl-C ends it without a traceback."""
    try:
        from geoweave.cli.main import main

        return main()
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(run())
