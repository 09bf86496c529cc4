"""A weave in a notebook, to be turned: the page of ``geoweave show`` within a cell."""

from __future__ import annotations

import base64
import html
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import Any

from geoweave.fabrication import viewer_html
from geoweave.files import replacing, text_job
from geoweave.rods import Relaxed
from geoweave.viz.picture import INLINE_BYTES, INLINE_WIDTH, Picture
from geoweave.viz.turned_scene import page_within
from geoweave.viz.woven_picture import weave as still
from geoweave.weave import Weave, inspected

__all__ = ["Turnable", "show"]

HEIGHT = 560
"""Of the page within a cell, pixels; at most so many, the controls stand beside the weave."""


@dataclass(frozen=True, eq=False)
class Turnable:
    """A weave to be turned and looked at.

    In JupyterLab and Jupyter Notebook it displays itself as the page of ``geoweave show``. Where pages within
    pages are taken out, as on GitHub, the still picture below it is seen.

    Attributes
    ----------
    design : the weave
    rest : the same weave at rest, if it was relaxed
    title : of the page
    height : of the page within the cell, pixels
    """

    design: Weave
    rest: Relaxed | None
    title: str
    height: int = HEIGHT

    @cached_property
    def page(self) -> str:
        """The page, which needs nothing but itself."""
        return viewer_html(self.design, self.rest, inspected(self.design).document(), self.title)

    @cached_property
    def picture(self) -> Picture:
        """The still picture."""
        return still(self.design if self.rest is None else self.rest, title=self.title)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the page to a file, whole or not at all."""
        with replacing(path) as temporary:
            text_job(self.page)(temporary)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        png = self.picture.png_within(INLINE_BYTES, INLINE_WIDTH, palette=True)
        return {
            "text/html": _framed(self.page, png, self.picture.alt, self.height),
            "image/png": png,
            "text/plain": f"Turnable({self.picture.alt!r})",
        }


def show(woven: Weave | Relaxed, *, title: str = "weave", height: int = HEIGHT) -> Turnable:
    """Show a weave in a notebook, to be turned, zoomed and looked at as on the page of ``geoweave show``.

    Parameters
    ----------
    woven : a weave, or what `geoweave.relax` makes of one, which is shown at rest and as designed
    title : of the page
    height : of the page within the cell, pixels

    Returns
    -------
    What displays itself at the end of a cell; ``save`` writes the page to a file.

    See Also
    --------
    weave : the still picture

    Examples
    --------
    >>> turned = viz.show(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8), title="a cone")
    >>> "<title>a cone: the weave</title>" in turned.page
    True
    """
    if isinstance(woven, Relaxed):
        return Turnable(woven.weave, woven, title, height)
    return Turnable(woven, None, title, height)


def _framed(page: str, png: bytes, alt: str, height: int) -> str:
    """A page within a cell, in front of the still picture, which is seen where frames are taken out."""
    said, data = html.escape(alt), base64.b64encode(png).decode("ascii")
    fills = "position:absolute;left:0;top:0;width:100%;height:100%;border:0"
    return (
        f'<div style="position:relative;height:{height}px;background:#fbfaf7">'
        f'<img src="data:image/png;base64,{data}" alt="{said}" style="{fills};object-fit:contain">'
        f"{page_within(page, alt, fills)}</div>"
    )
