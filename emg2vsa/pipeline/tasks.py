"""Tasks: a function by name and its arguments, so that only the process that runs one loads what it needs."""

from __future__ import annotations

import importlib
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from emg2vsa.errors import Emg2vsaError


@dataclass(frozen=True)
class Task:
    """``function`` is "module:name"; calling the task gives one ``Ended`` per step in ``steps``."""

    steps: tuple[str, ...]
    function: str
    arguments: Mapping[str, Any]

    def __call__(self) -> list[Ended]:
        module, _, name = self.function.partition(":")
        ended: list[Ended] = getattr(importlib.import_module(module), name)(**self.arguments)
        return ended


@dataclass(frozen=True)
class Ended:
    """How one step ended. ``final``: the same input would fail the same way."""

    step: str
    status: str
    message: str = ""
    final: bool = False


def guarded(step: str, make: Callable[[], object]) -> Ended:
    """Run one step; whatever goes wrong stays with this step. Text that ``make`` returns is to be said aloud."""
    try:
        said = make()
    except Emg2vsaError as error:
        return Ended(step, "failed", str(error), final=True)
    except Exception as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(frame.filename).name}:{frame.lineno}"
        fault = (
            f"unexpected {type(error).__name__} in {place}: {error}. This is a fault of the program; please report it."
        )
        return Ended(step, "failed", fault)
    return Ended(step, "done", said if isinstance(said, str) else "")
