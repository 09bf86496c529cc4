"""From a mesh file to a surface that can be worked on (Section 5.2), and back to a file.

`read_mesh` reads a file and mends it, `prepare_arrays` mends arrays. `isotropic_remesh` covers a surface with
even triangles. `write_mesh` writes a file.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
