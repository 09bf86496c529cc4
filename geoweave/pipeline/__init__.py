"""From mesh files to folders of woven files: one in one call, or many in a resumable sweep."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
