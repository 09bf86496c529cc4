from __future__ import annotations

import numpy as np
import pytest

from geoweave.errors import MeshError
from geoweave.models import shapes
from geoweave.surface.twisted_mesh import TwistedMesh


def test_signs_that_contradict_each_other_are_refused():
    mesh = shapes.torus(faces=300)
    signs = np.ones(mesh.faces.shape)
    with pytest.raises(MeshError, match="must be \\+1 or -1"):
        TwistedMesh(mesh.vertices, mesh.faces, signs=0.5 * signs)
    with pytest.raises(MeshError, match="have shape"):
        TwistedMesh(mesh.vertices, mesh.faces, signs=np.ones(3))
    signs[7, 1] = -1.0
    with pytest.raises(MeshError, match="2 edges have signs that disagree at their ends"):
        TwistedMesh(mesh.vertices, mesh.faces, signs=signs)


def test_a_mesh_whose_signs_are_all_plus_is_not_twisted():
    mesh = shapes.torus(faces=300)
    same = TwistedMesh(mesh.vertices, mesh.faces, signs=np.ones(mesh.faces.shape))
    np.testing.assert_array_equal(same.transport, mesh.transport)
    np.testing.assert_array_equal(same.bundle.forms, mesh.bundle.forms)
    assert not same.bundle.twisted_components.any()
