"""What the file ``weave.json`` calls itself; whoever reads one needs no more of a weave than this."""

from __future__ import annotations

__all__ = ["WEAVE_FORMAT", "WEAVE_VERSION"]

WEAVE_FORMAT, WEAVE_VERSION = "geoweave-weave", 1
"""What the first lines of ``weave.json`` say."""
