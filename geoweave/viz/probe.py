"""A picture of one triangle, drawn off-screen in a child process to learn whether rendering works here.

VTK may end the whole process by a signal where no graphics library is found, so ``geoweave doctor`` runs
``python -m geoweave.viz.probe`` as a child and reads one JSON object from its standard output.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np
import pyvista


def draw() -> dict[str, object]:
    """Draw a red triangle on white ground and report what was drawn with.

    Returns
    -------
    ``window`` (VTK's class), ``renderer`` (the driver's own name for itself), ``seconds``, and ``red``, the
    share of the picture's pixels that are the triangle; a working renderer gives about a fifth.
    """
    started = time.perf_counter()
    triangle = pyvista.PolyData(
        np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), faces=np.array([3, 0, 1, 2])
    )
    plotter = pyvista.Plotter(off_screen=True, window_size=[96, 96])
    plotter.background_color = "white"
    plotter.add_mesh(triangle, color="red", lighting=False)
    plotter.view_xy()
    picture = np.asarray(plotter.screenshot(return_img=True))
    window = plotter.render_window
    capabilities = window.ReportCapabilities() if window is not None else ""
    name = type(window).__name__
    plotter.close()
    renderer = next(
        (line.split(":", 1)[1].strip() for line in capabilities.splitlines() if "renderer string" in line), ""
    )
    red = (picture[..., 0] > 200) & (picture[..., 1] < 60) & (picture[..., 2] < 60)
    return {
        "window": name,
        "renderer": renderer,
        "red": round(float(red.mean()), 3),
        "seconds": round(time.perf_counter() - started, 2),
    }


if __name__ == "__main__":
    sys.stdout.write(json.dumps(draw()) + "\n")
