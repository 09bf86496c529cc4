"""Sparse systems: one factorisation, many solves (Appendices B and C).

Matrices come in, vectors go out; nothing here knows a mesh. `factorized` chooses the solver: SuperLU on small
systems, our compiled Cholesky with nested dissection on large ones.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
