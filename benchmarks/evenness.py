"""What a smoother s costs with the phase coupled: ``python -m benchmarks.evenness [NAME]...``.

Each model is woven once per mu of Eqs. 7 and 8, at the default scale: how uneven the spacing is, how much
ribbons bend, and what else changes. The table is written beside this module.
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

from benchmarks import scans
from geoweave.meshing import evened
from geoweave.weave import design, weave_pattern
from geoweave.weave.regularity import Regularity

SMOOTHNESS = (3e-4, 1e-3, 3e-3, 1e-2)
"""mu in squared bounding radii; 1e-3 is the default."""

NAMES = ("vessel", "spot")
"""Woven if nothing else is asked for: a long shape, and a scan."""

KEPT = Path(__file__).with_name("evenness.csv")


def measure(name: str, mu: float) -> dict:
    """Weave a surface at one mu."""
    design.EVENNESS = mu
    weave = weave_pattern(evened(scans.surface(name), name=name).mesh)
    found, metrics = Regularity.of(weave), weave.metrics()
    return {
        "name": name,
        "mu": mu,
        "spread": round(found.spacing_spread, 4),
        "curvature": round(metrics["geodesic_curvature"]["mean"] * weave.placement.scale, 4),
        "deviation": round(metrics["deviation_deg"]["median"], 3),
        "dislocations": metrics["dislocations"],
        "piled": round(found.piled, 4),
        "near_ideal": round(found.near_ideal, 4),
        "alternation": round(weave.interlacing.alternation, 4),
        "ribbons": len(weave.ribbons),
    }


def main() -> None:
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measure(sys.argv[2], float(sys.argv[3]))))
        return
    names, rows = sys.argv[1:] or NAMES, []
    for name in names:
        for mu in SMOOTHNESS:
            command = [sys.executable, "-m", "benchmarks.evenness", "--one", name, repr(mu)]
            done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
            rows.append(json.loads(done.stdout))
            print(" ".join(f"{key} {value}" for key, value in rows[-1].items()), flush=True)
    if set(names) == set(NAMES):
        with KEPT.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
