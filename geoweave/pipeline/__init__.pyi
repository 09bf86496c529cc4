from .batch import sweep as sweep
from .cut_request import CutRequest as CutRequest
from .cutting import CutFiles as CutFiles, cut_folder as cut_folder
from .design import WovenFiles as WovenFiles, weave_file as weave_file
from .editing import EditedFiles as EditedFiles, edit_folder as edit_folder
from .field_arrays import (
    FieldOfFile as FieldOfFile,
    field_file as field_file,
    foliate_file as foliate_file,
)
from .object_rigidity import Rigidity as Rigidity, rigidity as rigidity
from .pattern_twin import TwinOfFile as TwinOfFile, twin_file as twin_file
from .relaxed_file import RestOfFile as RestOfFile, relax_file as relax_file
from .request import WeaveRequest as WeaveRequest, formats_of as formats_of
from .showing import Shown as Shown, show_folder as show_folder
from .source import MeshSource as MeshSource, Say as Say, prepared_surface as prepared_surface
from .sweep_table import TABLES as TABLES, Row as Row
from .verdict import DO_NOT as DO_NOT, HOLDS as HOLDS, Verdict as Verdict
from .weave_folder import (
    DESIGN as DESIGN,
    check_formats as check_formats,
    earlier_report as earlier_report,
    listed_files as listed_files,
    text_jobs as text_jobs,
    write_reported as write_reported,
    write_texts as write_texts,
    write_weave as write_weave,
)
from .workers import check_dask as check_dask
