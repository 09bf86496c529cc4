"""The mechanics of a weave (Appendix E): elastic rods, contacts, sliding and relaxing."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
