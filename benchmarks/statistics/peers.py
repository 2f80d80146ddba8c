"""Libraries to compare with; None where one is not installed."""

from __future__ import annotations

import importlib
from typing import Any


def _optional(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


statsmodels_api = _optional("statsmodels.api")
statsmodels_formula = _optional("statsmodels.formula.api")
pingouin = _optional("pingouin")
scikit_posthocs = _optional("scikit_posthocs")
lmfit = _optional("lmfit")
