#!/usr/bin/env bash
# Reproduces one representative result of the paper, the sphere of Fig. 7, from a fresh clone; takes no parameters.
# It makes .venv from the pinned versions, draws the figure into build/replicate/, compares its numbers with the
# committed ones, and ends with PASS or FAIL (exit status 0 or 1). Needs python3, python3-venv and make.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec make --no-print-directory replicate </dev/null
