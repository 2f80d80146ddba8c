"""Flow engines of other installed packages: entry points of ``casr.flow_engines``, each a callable that makes one.

``engine(settings)`` gets the `FlowSettings` and returns an `Engine` (``casr.flow.step``). What it returns and raises is
looked at in every step, so that a fault of it is told as one.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from casr.errors import CasrError, SettingError, said_by
from casr.flow.region import Points, Region
from casr.flow.step import Engine, FlowSettings, FlowStep
from casr.images import Grey
from casr.plugins import Plugin, plugins


class PluginEngine:
    """The engine of another package that ``settings.engine`` names.

    Raises
    ------
    SettingError : there is none of this name.
    PluginError : it cannot be imported or made; in ``start`` and ``step``, it failed or broke its contract.
    """

    def __init__(self, settings: FlowSettings) -> None:
        self._plugin = _named(settings.engine)
        make = self._plugin.load()
        with self._faults("an engine that can be made"):
            self._engine: Engine = make(settings)
        self._start_notes: tuple[str, ...] = ()

    def start(self, image: Grey, region: Region, pins_px: Points | None) -> None:
        with self._faults("an engine that takes the first frame"):
            self._engine.start(image, region, pins_px)
        self._start_notes = (f"growth is measured by the flow engine {self._plugin}",)

    def step(self, image: Grey, pins_px: Points | None) -> FlowStep:
        with self._faults("an engine that takes the next frame"):
            step = self._engine.step(image, pins_px)
        if not isinstance(step, FlowStep) or not np.isfinite([step.divergence, step.log_growth]).all():
            raise self._plugin.fault("a FlowStep with finite growth from step", repr(step)[:80])
        notes, self._start_notes = self._start_notes, ()
        return replace(step, notes=(*notes, *step.notes))

    @contextmanager
    def _faults(self, wanted: str) -> Iterator[None]:
        try:
            yield
        except CasrError:
            raise
        except Exception as error:  # of foreign code, which may stumble over anything
            raise self._plugin.fault(wanted, said_by(error)) from error


def _named(name: str) -> Plugin:
    for plugin in plugins("casr.flow_engines"):
        if plugin.name == name:
            return plugin
    raise SettingError("engine", wanted="an engine that is installed", found=repr(name), do="Install its package.")
