from . import batch as batch
from .batch import Row as Row
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
