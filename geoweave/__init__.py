"""Weaving Geodesic Foliations (Vekhter et al. 2019), reproducible: from a mesh to a geodesic field and on.

The package is cut like the paper. `TriMesh` is the surface, `smoothest_field` and `diffused_field` make a
start, `geodesic_field` is Algorithm 1, `streamlines` shows what came of it. Pictures are in `geoweave.viz`,
which is imported only when asked for.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
