"""From a weave to files that a person cuts and weaves by (Section 5.4, Appendix F).

Flat strips with marks, their pieces on sheets, drawings, a cut list, the guide and a model to turn.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
