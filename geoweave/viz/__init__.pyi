from . import style as style
from .arrows import Arrows as Arrows, face_arrows as face_arrows, mark as mark, scattered as scattered
from .charts import (
    Drop as Drop,
    Front as Front,
    alternation_chart as alternation_chart,
    convergence_chart as convergence_chart,
    drop_chart as drop_chart,
    front_chart as front_chart,
)
from .fastened_scene import held_crossings as held_crossings
from .film import Film as Film, relaxing as relaxing
from .layout import gallery as gallery
from .pages import Page as Page, strips_page as strips_page
from .periodic import (
    Periodic as Periodic,
    add_theta as add_theta,
    periodic_gallery as periodic_gallery,
    theta_values as theta_values,
)
from .picture import Picture as Picture
from .plate import Lines as Lines, Note as Note, Plate as Plate, projections as projections
from .plate_layout import plates as plates
from .publishing import mesh_digest as mesh_digest, provenance as provenance, publish as publish
from .rods import Sprung as Sprung, at_rest as at_rest, rod_gallery as rod_gallery
from .scales import (
    Scale as Scale,
    deviation_scale as deviation_scale,
    energy_scale as energy_scale,
    factor_scale as factor_scale,
    heat_scale as heat_scale,
    theta_scale as theta_scale,
)
from .scene import Scene as Scene
from .shading import (
    Family as Family,
    Shaded as Shaded,
    deviation_panel as deviation_panel,
    shaded_gallery as shaded_gallery,
)
from .sheets import (
    cut_edges as cut_edges,
    family_lines as family_lines,
    rosy_scene as rosy_scene,
    sheet_arrows as sheet_arrows,
    sheet_colours as sheet_colours,
    sheet_names as sheet_names,
    stacked_sheets as stacked_sheets,
    theta_scene as theta_scene,
)
from .smoothing import smoothed as smoothed
from .solids import bands as bands, strips as strips
from .streamline_panels import (
    Panel as Panel,
    curl_scale as curl_scale,
    curvature_scale as curvature_scale,
    streamline_gallery as streamline_gallery,
)
from .sweeps import Sweep as Sweep, sweep_chart as sweep_chart
from .tables import whole as whole
from .turnable import Turnable as Turnable, show as show
from .turned_scene import Turned as Turned, turn as turn
from .views import FROM_ABOVE as FROM_ABOVE, VIEWS as VIEWS, View as View
from .weaves import (
    Woven as Woven,
    clear_place as clear_place,
    colouring as colouring,
    weave_gallery as weave_gallery,
    weave_scene as weave_scene,
)
from .woven_picture import weave as weave
