"""What was done to a mesh before it became a surface, in counts and in words."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from geoweave.arrays import Vectors
from geoweave.wording import counted

_SENTENCES = {
    "unreferenced_vertices": "dropped {} that no face uses",
    "welded_vertices": "welded {} to another at the same place",
    "degenerate_faces": "dropped {} without area",
    "flipped_edges": "flipped {} to take a face without area away",
    "duplicate_faces": "dropped {} with the vertices of another",
    "dropped_components": "left out {} smaller than the largest",
    "cut_edges": "cut {} shared by more than two faces",
    "turned_faces": "turned {} over",
    "split_vertices": "added {} where separate fans of faces met in one",
    "remeshed_from": "remeshed, from {}",
}
_PLURALS = {"vertices": "vertex", "faces": "face", "edges": "edge", "components": "component", "from": "face"}


@dataclass(frozen=True)
class RepairReport:
    """How often each repair was needed; all zero for a mesh taken as it was.

    Attributes
    ----------
    unreferenced_vertices : vertices in no face, dropped
    welded_vertices : vertices joined with another at the same place
    degenerate_faces : faces with a repeated vertex or without area, dropped
    flipped_edges : edges flipped to take a face without area away and leave no slit
    duplicate_faces : faces with the vertices of another, dropped
    dropped_components : components left out because only the largest was asked for
    cut_edges : edges shared by more than two faces, cut apart because that was asked for
    turned_faces : faces turned over, to agree with their neighbours or to face outwards
    split_vertices : vertices added where separate fans of faces met in one
    remeshed_from : number of faces before remeshing; 0 when not remeshed
    notes : sentences on what was read otherwise than the file says, and on faults that were left as they are
    """

    unreferenced_vertices: int = 0
    welded_vertices: int = 0
    degenerate_faces: int = 0
    flipped_edges: int = 0
    duplicate_faces: int = 0
    dropped_components: int = 0
    cut_edges: int = 0
    turned_faces: int = 0
    split_vertices: int = 0
    remeshed_from: int = 0
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, int]:
        """Return the counts by name, zeros too; the notes are left out."""
        counts = asdict(self)
        del counts["notes"]
        return counts

    def sentences(self) -> list[str]:
        """Say in words what was done, one entry per kind of repair that was needed, and then the notes."""
        done = ((key, n) for key, n in self.as_dict().items() if n)
        said = [_SENTENCES[key].format(counted(n, _PLURALS[key.split("_")[1]])) for key, n in done]
        return [*said, *self.notes]


def place(points: Vectors) -> str:
    """The mean of (N, 3) points, as it is written in a message."""
    return "(" + ", ".join(f"{x:.6g}" for x in points.mean(axis=0)) + ")"
