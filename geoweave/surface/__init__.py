"""The surface T of Section 4: an oriented manifold triangle mesh, parts of it, and points near it.

`TriMesh` is the mesh. On a `TwistedMesh` values change their sign round some loops, as on the quotient of a
cover of even degree. A `Part` is what is left when faces are taken away.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
