from . import cholesky as cholesky, factorization as factorization
from .eigenvectors import smallest_eigenvectors as smallest_eigenvectors
from .factorization import (
    Analysis as Analysis,
    Assembly as Assembly,
    Factorization as Factorization,
    Ordering as Ordering,
    analysed as analysed,
    bounded_minimum as bounded_minimum,
    factorized as factorized,
    nested_dissection as nested_dissection,
    one_blas_thread as one_blas_thread,
    smallest_eigenpair as smallest_eigenpair,
)
from .reuse import Reused as Reused, near_solution as near_solution
