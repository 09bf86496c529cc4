"""Curves on a surface (Section 3): streamlines, straightest geodesics, and how much they bend."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
