from .contact_order import Changes as Changes, order_changes as order_changes, positions as positions
from .crossing_forces import (
    FRICTION as FRICTION,
    ContactForces as ContactForces,
    contact_forces as contact_forces,
)
from .curved_weave import STRIPS as STRIPS, StripKind as StripKind, curved as curved
from .departure import (
    Distances as Distances,
    fitted as fitted,
    mean_tilt as mean_tilt,
    rigid_fit as rigid_fit,
    vertex_weights as vertex_weights,
)
from .elastic_energies import energy_density as energy_density
from .equilibrium import Equilibrium as Equilibrium, Step as Step
from .firmest_sides import firmest as firmest
from .from_ribbons import (
    FINENESS as FINENESS,
    file_of_rods as file_of_rods,
    rods_of_file as rods_of_file,
    rods_of_ribbons as rods_of_ribbons,
)
from .natural_curvature import natural_of_strips as natural_of_strips
from .rest_stiffness import (
    RestStiffness as RestStiffness,
    SoftMotions as SoftMotions,
    on_the_floor as on_the_floor,
)
from .rod_file import RodFile as RodFile, read_rods as read_rods, rod_text as rod_text
from .rods import Contacts as Contacts, Layout as Layout, Material as Material, Rods as Rods
from .slid_weave import (
    ElasticWeave as ElasticWeave,
    SlidWeave as SlidWeave,
    elastic_rods as elastic_rods,
    slide as slide,
    surface_of_weave as surface_of_weave,
)
from .slide_and_relax import Springs as Springs, relax_rods as relax_rods, slide_rods as slide_rods
from .steps import Stepping as Stepping
from .strip_fitting import (
    CurvedStep as CurvedStep,
    CurvedStrips as CurvedStrips,
    Fitting as Fitting,
    optimal_strips as optimal_strips,
)
from .weave_at_rest import (
    Relaxed as Relaxed,
    relax as relax,
    relaxed_weave as relaxed_weave,
    vertex_normals as vertex_normals,
)
from .weave_file import at_rest as at_rest, read_weave as read_weave, rods_of_document as rods_of_document
