"""The object that a pattern makes, put together from its flat strips alone (Section 5.4)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
