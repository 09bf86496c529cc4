from .mirror_halves import mirrored_half as mirrored_half
from .place_order import ordered_by_place as ordered_by_place
from .prepare import (
    Components as Components,
    Prepared as Prepared,
    prepare_arrays as prepare_arrays,
    read_mesh as read_mesh,
    remeshed as remeshed,
)
from .remesh import check_face_count as check_face_count, isotropic_remesh as isotropic_remesh
from .report import RepairReport as RepairReport
from .weaving_mesh import evened as evened, faces_to_weave_on as faces_to_weave_on
from .write import check_format as check_format, write_mesh as write_mesh
