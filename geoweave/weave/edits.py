"""Changes that a person makes to a weave: a key that says of which weave they are."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

__all__ = ["design_key"]


def design_key(document: Mapping[str, Any]) -> str:
    """Sixteen letters that tell designs apart: names of ribbons, and which of them cross in which order.

    Lengths do not enter, so that a weave has the same key at any size and width.

    Parameters
    ----------
    document : the contents of ``weave.json``
    """
    said = [
        [each["label"] for each in document["ribbons"]],
        [[*each["ribbons"], each["over_index"]] for each in document["crossings"]],
    ]
    text = json.dumps(said, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]
