"""Peak memory of this process."""

from __future__ import annotations

import resource
import sys


def peak_gigabytes() -> float:
    """Largest resident size so far, in units of 10^9 bytes."""
    # Kilobytes on Linux, bytes on macOS.
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e9
