"""From a geodesic field to a periodic function whose level sets follow it (Section 4.2, Appendix C).

The integrating factor s (Eq. 7), theta (Eq. 8), both in alternation: `foliate`; and the level sets.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
