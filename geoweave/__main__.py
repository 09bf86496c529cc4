"""``python -m geoweave``."""

import sys

from geoweave.cli import main

if __name__ == "__main__":
    sys.exit(main())
