"""From a foliation of a branched cover to a woven design (Sections 5.1 and 5.2).

The cover, ribbons, over and under, widths, and what is hard to make. `weave_pattern` does it in one call.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
