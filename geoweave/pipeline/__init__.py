"""From files to files, each in one call.

`weave_file` weaves the mesh of a file, relaxes the weave and writes what it is made by; `sweep` does so for
many meshes and goes on where it stopped. `field_file` and `foliate_file` stop at Part 1 of the paper,
`relax_file` is the physics alone, `twin_file` puts a pattern together from its strips.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
