"""What a stage is: each file of ``emg2vsa.pipeline.stages`` declares one as ``STAGE``; nothing else says what it is.

A step is a stage for one item: one recording, one participant, one run of the rig, one of its mountings, one design
(angle and condition), or the whole study. ``run`` gets
what the declaration names and nothing else, so that everything a result depends on is part of the step's key.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from emg2vsa.pipeline.campaign import Campaign

Part = Literal["people", "emulated rig", "runs", "report"]
"""Recordings of people; runs that an emulated rig makes; runs of any rig; all of them."""

Input = tuple[str, str]
"""Stage and item of a step whose result another step takes."""


@dataclass(frozen=True)
class Given:
    """What ``run`` gets.

    settings : what ``Stage.settings`` returned. files : the paths that ``Stage.files`` returned. inputs : stage to the
    results of its steps, in the study's order; steps that failed are left out. failures : (item, stage, message) of
    every failed step, for a stage that tells them. folder : where a stage that writes files writes them.
    """

    item: str
    settings: Mapping[str, Any]
    files: Mapping[str, Sequence[Path]] = field(default_factory=dict)
    inputs: Mapping[str, Sequence[Path]] = field(default_factory=dict)
    failures: Sequence[tuple[str, str, str]] = ()
    folder: Path | None = None

    def each(self, stage: str) -> Iterator[Any]:
        """The results of a stage, loaded one at a time. DamagedResult where one is not as it was stored.

        Arrays of a result share the memory of its file: a stage of the whole study that keeps one copies it.
        """
        from emg2vsa import artifacts  # loads NumPy, which planning does without

        return (artifacts.load(path) for path in self.inputs.get(stage, ()))

    def all(self, stage: str) -> list[Any]:
        """All results of a stage at once, as ``each``."""
        return list(self.each(stage))

    def one(self, stage: str) -> Any:
        """The result of a stage that has one step; None where it failed."""
        return next(self.each(stage), None)


@dataclass(frozen=True)
class Keyed:
    """A setting of which only ``key`` counts: what the value holds besides changes no result."""

    value: Any
    key: Any


def value_of(setting: Any) -> Any:
    """A setting as ``run`` gets it."""
    return setting.value if isinstance(setting, Keyed) else setting


def nothing(campaign: Campaign, item: str) -> dict[str, Any]:
    """No settings, or no files."""
    return {}


PLANNED = ("settings", "files", "takes", "folder", "alone_in")


@dataclass(frozen=True)
class Stage:
    """One stage. What `PLANNED` names is called while a study is planned; a step itself calls ``run`` and ``says``.

    needs : stages whose results it takes. per : what it runs for. of : the part of a study it belongs to.
    run : makes the product from what is given; a stage that writes files returns their paths, all inside its folder.
    settings : name to value, all that ``run`` may use of the study; paths in it are not part of the key.
    files : role to the files outside the store that ``run`` reads; their content is part of the key.
    takes : the inputs of one item, where they are not what ``needs`` and ``per`` say.
    folder : where the files go that it writes; None for a stage whose product is stored.
    alone_in : folder that holds nothing but its files; a file more in it makes the step stale.
    says : what a person should read of a product, "" where nothing.
    tells_failures : ``run`` gets the messages of all failed steps.
    loads : modules that its steps load, so that workers may share them from the start.
    gives : what it puts into the report, with a verb, such as "The mean profiles are".
    alone : up to so many steps run in the calling process, as starting workers would take longer.
    on_request : its steps run only where somebody asks for them; a result that is fresh counts, others do not exist.
    """

    per: Literal["recording", "run", "mounting", "design", "participant", "study"]
    of: Part
    run: Callable[[Given], Any]
    needs: tuple[str, ...] = ()
    settings: Callable[[Campaign, str], dict[str, Any]] = nothing
    files: Callable[[Campaign, str], Mapping[str, Sequence[str | Path]]] = nothing
    takes: Callable[[Campaign, str], Sequence[Input]] | None = None
    folder: Callable[[Campaign, str], Path] | None = None
    alone_in: Callable[[Campaign, str], Path] | None = None
    says: Callable[[Any], str] = lambda product: ""
    tells_failures: bool = False
    gives: str = "Results are"
    alone: int = 1
    loads: tuple[str, ...] = ()
    on_request: bool = False
