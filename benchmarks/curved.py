"""Weaves of straight and curved strips at rest: ``python -m benchmarks.curved MESH RIBBONS [...]``.

For each mesh and number of ribbons: how far the weave at rest is from its surface, in shares of the diagonal,
with straight, designed and optimal strips. The surfaces of *3D Weaving with Curved Ribbons* (Ren et al. 2021)
are not part of this repository; beside a mesh called ``bean`` their figures are shown. Theirs are for ribbons
0.0333 wide, here ribbons have the default width.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import perf_counter

from geoweave.pipeline.source import MeshSource, prepared_surface
from geoweave.rods.curved_weave import STRIPS
from geoweave.rods.weave_at_rest import relaxed_weave
from geoweave.weave.design import weave_pattern

PUBLISHED = {"bean": "straight 2.26 %, after their first stage 0.52 %, at the end 0.19 %"}
"""Mean distances that Ren et al. report."""

FACES = 8_000


def measure(mesh: str, ribbons: int) -> list[dict]:
    """Weave a mesh once, and let it come to rest with strips of each kind."""
    prepared = prepared_surface(MeshSource(mesh, faces=FACES), {}, lambda text: None)
    weave = weave_pattern(prepared.mesh, ribbons=ribbons)
    rows = []
    for strips in STRIPS:
        clock = perf_counter()
        found = relaxed_weave(weave, strips=strips)
        far, said = found.departure.to_surface, found.metrics().get("curved_strips", {})
        rows.append(
            {
                "model": Path(mesh).stem,
                "ribbons": len(weave.ribbons),
                "strips": strips,
                "mean": far.mean,
                "rms": far.rms,
                "largest": far.largest,
                "sharpest": said.get("sharpest", 0.0),
                "converged": said.get("converged", found.converged),
                "seconds": perf_counter() - clock,
            }
        )
    return rows


def main(arguments: list[str]) -> None:
    """Print the table."""
    print("model        ribbons strips      mean %   rms %  largest %  k x w  converged  seconds")
    for mesh, ribbons in zip(arguments[::2], arguments[1::2], strict=True):
        for row in measure(mesh, int(ribbons)):
            print(
                f"{row['model']:12} {row['ribbons']:7d} {row['strips']:9} {100 * row['mean']:8.3f} "
                f"{100 * row['rms']:7.3f} {100 * row['largest']:10.2f} {row['sharpest']:6.2f} "
                f"{row['converged']!s:>10} {row['seconds']:8.1f}",
                flush=True,
            )
        if Path(mesh).stem in PUBLISHED:
            print(f"{Path(mesh).stem:12} Ren et al. (2021), mean: {PUBLISHED[Path(mesh).stem]}")


if __name__ == "__main__":
    main(sys.argv[1:] or ["bunny", "60"])
