"""From a mesh file to a surface that can be worked on (Section 5.2), and back to a file.

`read_mesh` reads and mends, `isotropic_remesh` makes triangles even, `write_mesh` writes.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
