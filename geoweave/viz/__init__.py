"""Pictures: the only room of the package that imports a renderer or a plotting library.

Drawing returns a `Picture`, which shows itself in a notebook; publishing it is separate and last::

    picture = viz.streamline_gallery([viz.Panel("Sphere", curves, view="sphere")])
    viz.publish("fig08_gallery", picture, table=table, params=params, inputs={"sphere": mesh})
"""

from __future__ import annotations

import os
import sys

if sys.platform.startswith("linux"):
    # Where VTK is left to choose, it tries a display first and prints what failed, with the time of day.
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

from geoweave.viz.charts import Drop, alternation_chart, convergence_chart, drop_chart
from geoweave.viz.film import Film, relaxing
from geoweave.viz.gallery import (
    VIEWS,
    Panel,
    Scale,
    curl_scale,
    curvature_scale,
    streamline_gallery,
)
from geoweave.viz.layout import gallery
from geoweave.viz.pages import Page, strips_page
from geoweave.viz.periodic import Periodic, add_theta, periodic_gallery
from geoweave.viz.picture import Picture
from geoweave.viz.publishing import mesh_digest, provenance, publish
from geoweave.viz.rods import Sprung, at_rest, bands, energy_scale, rod_gallery
from geoweave.viz.scene import Scene, View
from geoweave.viz.shading import (
    Family,
    Shaded,
    deviation_panel,
    deviation_scale,
    factor_scale,
    shaded_gallery,
)
from geoweave.viz.sheets import (
    cut_edges,
    family_lines,
    rosy_scene,
    sheet_arrows,
    sheet_colours,
    sheet_names,
    stacked_sheets,
    theta_scene,
)
from geoweave.viz.vectors import (
    FROM_ABOVE,
    Arrows,
    Lines,
    Note,
    Plate,
    face_arrows,
    heat_scale,
    mark,
    plates,
    projections,
    scattered,
)
from geoweave.viz.weaves import Woven, colouring, strips, weave_gallery, weave_scene

__all__ = [
    "FROM_ABOVE",
    "VIEWS",
    "Arrows",
    "Drop",
    "Family",
    "Film",
    "Lines",
    "Note",
    "Page",
    "Panel",
    "Periodic",
    "Picture",
    "Plate",
    "Scale",
    "Scene",
    "Shaded",
    "Sprung",
    "View",
    "Woven",
    "add_theta",
    "alternation_chart",
    "at_rest",
    "bands",
    "colouring",
    "convergence_chart",
    "curl_scale",
    "curvature_scale",
    "cut_edges",
    "deviation_panel",
    "deviation_scale",
    "drop_chart",
    "energy_scale",
    "face_arrows",
    "factor_scale",
    "family_lines",
    "gallery",
    "heat_scale",
    "mark",
    "mesh_digest",
    "periodic_gallery",
    "plates",
    "projections",
    "provenance",
    "publish",
    "relaxing",
    "rod_gallery",
    "rosy_scene",
    "scattered",
    "shaded_gallery",
    "sheet_arrows",
    "sheet_colours",
    "sheet_names",
    "stacked_sheets",
    "streamline_gallery",
    "strips",
    "strips_page",
    "theta_scene",
    "weave_gallery",
    "weave_scene",
]
