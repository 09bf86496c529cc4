from .bench import Bench as Bench
from .bill import Bill as Bill, bill_of as bill_of
from .colours import Colours as Colours
from .crossing_order import (
    Reordered as Reordered,
    order_sentence as order_sentence,
    reordered_crossings as reordered_crossings,
)
from .flattening import (
    WeaveLike as WeaveLike,
    free_end as free_end,
    pattern_of as pattern_of,
    trimmed as trimmed,
    weave_document as weave_document,
)
from .hoops import hooped as hooped
from .maker_files import (
    FORMATS as FORMATS,
    check_formats as check_formats,
    files_of as files_of,
    jobs_of as jobs_of,
    layout_for as layout_for,
    write as write,
)
from .measured_strips import MeasuredStrips as MeasuredStrips, beside as beside, measured as measured
from .nesting import Laid as Laid, Sheet as Sheet, Stock as Stock
from .numbers_of_layout import layout_numbers as layout_numbers
from .pattern import Pattern as Pattern
from .pdf import FOOT as FOOT, MARGIN as MARGIN, write_pdf as write_pdf
from .pieces import Making as Making, pieces_of as pieces_of
from .presets import LABELS as LABELS, PRESETS as PRESETS, Preset as Preset, preset_of as preset_of
from .sheet_materials import (
    MATERIALS as MATERIALS,
    SheetMaterial as SheetMaterial,
    material_of as material_of,
)
from .sheet_sizes import PAPERS as PAPERS, Paper as Paper, stock_of as stock_of
from .strip_drawing import drawn as drawn
from .strip_layout import StripLayout as StripLayout, layout as layout
from .svg import read_svg as read_svg
from .svg_pattern import SvgPattern as SvgPattern, pattern_of_svg as pattern_of_svg
from .up_axes import (
    base_axis as base_axis,
    check_axis as check_axis,
    up_axis as up_axis,
    upward as upward,
)
from .viewer_page import viewer_html as viewer_html
