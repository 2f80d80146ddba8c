"""The benchmarks, which lie beside the packages in a source checkout and are not installed with them."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import casr
from casr.errors import SettingError

SOURCE = Path(casr.__file__).parents[1]
"Folder of the packages; in a source checkout the benchmarks lie there too."


def benchmarks(module: str, program: str) -> ModuleType:
    """The module ``benchmarks.<module>``, which ``<program> bench`` runs. SettingError : it is not installed."""
    if not (SOURCE / "benchmarks").is_dir():
        raise SettingError(
            "bench", wanted=f"a source checkout, with benchmarks/ beside {SOURCE / program}", found="none",
            do=f"Get the sources of emg2vsa {casr.__version__} and run there: python -m {program}.cli bench",
        )  # fmt: skip
    if str(SOURCE) not in sys.path:
        sys.path.insert(0, str(SOURCE))
    return import_module(f"benchmarks.{module}")
