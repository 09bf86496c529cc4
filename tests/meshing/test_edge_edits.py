import numpy as np
import pytest

from geoweave.meshing.edge_edits import collapse_edges, flip_edges, relax_vertices
from geoweave.meshing.halfedge_patch import Guide, Patch
from geoweave.meshing.remesh import closed_up, opened_patch, split_long
from geoweave.models import shapes
from geoweave.surface.closest_point import segment_tree, triangle_tree
from geoweave.surface.mesh import TriMesh

SURFACES = {
    "sphere": lambda: shapes.sphere(faces=320),
    "torus": lambda: shapes.torus(faces=600),
    "annulus": lambda: shapes.annulus(faces=400),
    "Schwarz-P": lambda: shapes.schwarz_p(faces=1_600),
}


def opened(mesh: TriMesh) -> tuple[Patch, Guide]:
    rims = segment_tree(mesh.vertices[mesh.edges[mesh.boundary_edges]])
    guide = Guide(triangle_tree(mesh.vertices[mesh.faces]), rims, segment_tree(np.zeros((0, 2, 3))))
    return opened_patch(mesh, np.zeros(0, dtype=np.int64), mesh.mean_edge), guide


def surface(patch: Patch) -> TriMesh:
    """The mesh that a patch has become; TriMesh refuses it if it is no manifold."""
    kept = closed_up(patch)
    return TriMesh(kept.points, kept.at.reshape(-1, 3))


def topology(mesh: TriMesh) -> tuple[int, int, int]:
    return mesh.n_components, mesh.genus, len(mesh.boundary_loops)


@pytest.mark.parametrize("name", SURFACES)
def test_every_edit_keeps_the_topology(name: str) -> None:
    mesh = SURFACES[name]()
    patch, guide = opened(mesh)
    patch = split_long(patch, guide, 0.7 * mesh.mean_edge)
    finer = surface(patch)
    assert topology(finer) == topology(mesh)
    assert finer.edge_lengths.max() <= 0.7 * mesh.mean_edge
    everything = np.arange(len(patch.at))
    gone = collapse_edges(patch, guide, everything, 1.5 * mesh.mean_edge, 4 * mesh.mean_edge, 10**9)
    coarser = surface(patch)
    assert coarser.n_faces == finer.n_faces - gone
    assert gone > 0.5 * finer.n_faces
    assert topology(coarser) == topology(mesh)
    patch = closed_up(patch)
    flip_edges(patch, False)
    relax_vertices(patch, guide)
    flip_edges(patch, True)
    assert topology(surface(patch)) == topology(mesh)


@pytest.mark.parametrize("name", SURFACES)
def test_collapsing_everything_stops_at_the_topology(name: str) -> None:
    mesh = SURFACES[name]()
    patch, guide = opened(mesh)
    for _ in range(20):
        collapse_edges(patch, guide, np.arange(len(patch.at)), np.inf, np.inf, 10**9)
        patch = closed_up(patch)
    least = surface(patch)
    assert topology(least) == topology(mesh)
    assert least.n_faces < 0.3 * mesh.n_faces


def test_the_budgets_hold() -> None:
    mesh = shapes.sphere(faces=320)
    patch, guide = opened(mesh)
    assert surface(split_long(patch, guide, 0.0, 10)).n_faces == 330
    assert collapse_edges(patch, guide, np.arange(len(patch.at)), np.inf, np.inf, 10) == 10


def test_a_tetrahedron_is_left_alone() -> None:
    corners = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    patch, guide = opened(TriMesh(corners, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])))
    assert collapse_edges(patch, guide, np.arange(12), np.inf, np.inf, 10**9) == 0
    assert flip_edges(patch, False) + flip_edges(patch, True) == 0


def test_flips_make_a_plane_mesh_delaunay() -> None:
    rng = np.random.default_rng(5)
    mesh = shapes.square(faces=400)
    shake = rng.uniform(-0.3, 0.3, mesh.vertices.shape) * mesh.mean_edge
    shake[mesh.boundary_vertices] = 0.0
    shake[:, 2] = 0.0
    patch, _ = opened(TriMesh(mesh.vertices + shake, mesh.faces))
    while flip_edges(patch, True):
        pass
    flat = surface(patch)
    angle = flat.corner_angles.ravel()[flat.edge_halfedges[flat.interior_edges]]
    assert angle.sum(axis=1).max() < np.pi + 1e-5


def test_flips_bring_vertices_nearer_to_six_faces() -> None:
    mesh = shapes.square(faces=800)
    patch, _ = opened(mesh)

    def excess(mesh: TriMesh) -> int:
        faces = np.bincount(mesh.faces.ravel())
        return int(((faces - np.where(mesh.boundary_vertices, 3, 6)) ** 2).sum())

    flips = flip_edges(patch, False)
    assert flips > 0
    assert excess(surface(patch)) < excess(mesh)
