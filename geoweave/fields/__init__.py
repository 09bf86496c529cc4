"""Vector fields on faces and how they are found (Section 4.1, Appendices B and D).

Operators, fields of one and of N vectors a face, singularities, and Algorithm 1: `geodesic_field`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
