"""Pictures: the only room of the package that imports a renderer or a plotting library.

Drawing returns a `Picture`, which shows itself in a notebook; publishing it is separate and last::

    picture = viz.streamline_gallery([viz.Panel("Sphere", curves, view="sphere")])
    viz.publish("fig08_gallery", picture, table=table, params=params, inputs={"sphere": mesh})
"""

import os
import sys

import lazy_loader

if sys.platform.startswith("linux"):
    # Where VTK is left to choose, it tries a display first and prints what failed, with the time of day.
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
