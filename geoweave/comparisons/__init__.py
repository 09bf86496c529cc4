"""What the figures compare with: other fields, other integrations, the paper's own systems.

Nothing in the pipeline imports this room.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
