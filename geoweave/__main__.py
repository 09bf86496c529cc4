"""``python -m geoweave``."""

import sys

from geoweave.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
