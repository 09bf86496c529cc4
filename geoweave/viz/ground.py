"""The surface that ribbons lie on, sunk a little below them."""

from __future__ import annotations

from geoweave.surface import TriMesh
from geoweave.viz import style
from geoweave.viz.scene import Scene

LINING = 2.5
"""How much deeper the far side of an open surface is drawn, in depths of its near side."""


def add_ground(scene: Scene, mesh: TriMesh, depth: float) -> None:
    """Add the surface that ribbons lie on, sunk against its normals by a depth, lengths on the surface.

    Ribbons lie on one side of a surface. Where it is open, one may look at its other side, into a tube or
    under a rim, and there a ribbon that passes below others would stick out of it in pieces. So this side is
    drawn deeper, in front of them.

    Parameters
    ----------
    scene : to add to
    mesh : the surface
    depth : how far below it is drawn; negative where normals point away from the ribbons
    """
    sunk = mesh.vertices - depth * mesh.vertex_normals
    scene.add_surface(TriMesh(sunk, mesh.faces))
    if len(mesh.boundary_loops):
        deeper = mesh.vertices - LINING * depth * mesh.vertex_normals
        turned = mesh.faces if depth > 0 else mesh.faces[:, ::-1]
        scene.add_surface(TriMesh(deeper, turned), colour=style.SURFACE, behind=True)
