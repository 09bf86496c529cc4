import numpy as np
import pytest
from meshfiles import sphere

from geoweave.files import OutputError
from geoweave.meshing.prepare import read_mesh
from geoweave.meshing.report import RepairReport
from geoweave.meshing.write import WRITTEN, write_mesh
from geoweave.surface.mesh import TriMesh


@pytest.mark.parametrize("ending", WRITTEN)
def test_what_is_written_is_read_again_to_the_last_digit(ending, tmp_path):
    points, faces = sphere(2)
    mesh = TriMesh(points * np.pi + 1e6 / 3, faces)
    path = tmp_path / f"mesh{ending}"
    write_mesh(mesh, path)
    again = read_mesh(path)
    np.testing.assert_array_equal(again.mesh.vertices, mesh.vertices)
    np.testing.assert_array_equal(again.mesh.faces, mesh.faces)
    assert again.report == RepairReport()
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_another_ending_is_refused(tmp_path):
    with pytest.raises(OutputError, match=r"mesh\.stl: a mesh is written as \.obj, \.off, \.ply; choose"):
        write_mesh(TriMesh(*sphere(0)), tmp_path / "mesh.stl")
    assert not list(tmp_path.iterdir())
