"""Which steps are fresh, which are stale and why: the state of a study without computing anything."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from casr.blas_kernel import blas_kernel
from emg2vsa import artifacts
from emg2vsa.pipeline.campaign import Campaign, campaign
from emg2vsa.pipeline.code import Code, Reached
from emg2vsa.pipeline.fingerprint import Fingerprints, Part, Values, digest, state_of
from emg2vsa.pipeline.fingerprint import State as FileState
from emg2vsa.pipeline.ledger import Entry, Ledger, Parts, differences
from emg2vsa.pipeline.stage import Given, Stage, value_of
from emg2vsa.pipeline.stage_order import inputs, items, module_of, needs_runs, stage
from emg2vsa.pipeline.store import Store, WrittenFiles, remove_left_files
from emg2vsa.study import Study

DONE = frozenset({"fresh", "done"})
"""A result is there."""
REFUSED = frozenset({"failed", "blocked"})
"""There is none, and will be none before something changes."""
_NOTHING = Part("", {})
_AGAIN = "the last try ended unexpectedly"
_PROJECT = "{project}/"
"""Stands for the folder of the study file in messages that are kept."""


@dataclass
class Step:
    """One stage for one item, and where it stands.

    status : ``fresh``, ``stale`` with its reasons, ``waits`` for inputs that may turn out as they were, ``failed``,
    ``blocked`` by a failed input, or ``done`` just now. key : "" while an input is not known. result : digest of the
    stored result. reads : state of each file outside the store as it was digested. at : path of the result. types :
    modules that define what its settings are. loaded : what else it imports or looks up by name, as of its last run.
    """

    stage: str
    item: str
    parts: Parts
    key: str
    status: str = "stale"
    reasons: tuple[str, ...] = ()
    message: str = ""
    result: str = ""
    reads: dict[str, FileState | None] = field(default_factory=dict)
    at: str | None = None
    types: tuple[str, ...] = ()
    loaded: tuple[str, ...] = ()

    @property
    def id(self) -> str:
        return f"{self.stage}/{self.item}"


class StepPlan:
    """The state of all steps so far; the one place that knows keys.

    reading : nothing is recorded, and results below count for stages that write files too. asked : stages on request
    that somebody asks for; of others only steps are here that are fresh or may turn out to be.
    """

    def __init__(
        self,
        found: Campaign,
        store: Store,
        warn: Callable[[str], None],
        *,
        reading: bool,
        asked: Collection[str] = (),
    ) -> None:
        self.campaign, self.store, self._reading, self._asked = found, store, reading, asked
        self.ledger = Ledger(store.folder, warn)
        self._below = None if store.below is None else Ledger(store.below)
        self.prints = memory_of_files(store.folder, warn)
        self._code, self._values = Code(self.prints), Values()
        self._base = str(self.study.path.parent)
        self.steps: dict[str, Step] = {}
        self._of: dict[str, list[Step]] = {}

    @property
    def study(self) -> Study:
        """The study, with its runs."""
        return self.campaign.study

    def add_stage(self, name: str) -> list[Step]:
        """Every step of a stage, given the steps of the stages before it."""
        added = [self._step(name, item) for item in items(self.campaign, name)]
        if stage(name).on_request and name not in self._asked:
            added = [step for step in added if step.status in DONE or step.status == "waits"]
        self._of[name] = added
        self.steps.update((step.id, step) for step in added)
        return added

    def done(self, name: str, of: Iterable[str] | None = None) -> tuple[Path, ...]:
        """Results of a stage that are there, in the study's order; of all items, or of these."""
        steps = self._of.get(name, ()) if of is None else [self.steps[f"{name}/{item}"] for item in of]
        return tuple(Path(step.at) for step in steps if step.status in DONE and step.at is not None)

    def files(self, name: str) -> list[Path]:
        """The files that the steps of a stage wrote."""
        found = []
        for step in self._of.get(name, ()):
            if step.status in DONE and step.at is not None:
                folder = self.folder(name, step.item)
                found += [folder / each for each in artifacts.load(step.at).names]
        return found

    def failures(self, steps: Iterable[Step] | None = None) -> tuple[tuple[str, str, str], ...]:
        """(item, stage, message) of every failed step, or of those of ``steps``."""
        failed = (step for step in (self.steps.values() if steps is None else steps) if step.status == "failed")
        return tuple((step.item, step.stage, step.message) for step in failed)

    def other_kernels(self) -> dict[str, int]:
        """Kernels of BLAS, other than this computer's, that made results which are fresh here: how many each made."""
        made = Counter(self.kernel_of(step) for step in self.steps.values() if step.status == "fresh")
        return {kernel: count for kernel, count in sorted(made.items()) if kernel not in ("", blas_kernel())}

    def kernel_of(self, step: Step) -> str:
        """BLAS kernel that made the result of a step; "" where nobody noted it."""
        entry = self.ledger.with_key(step.id, step.key)
        return "" if entry is None else entry.kernel

    def given(self, step: Step) -> Given:
        """Inputs of the step's ``run``; the states of files that earlier steps wrote are noted as ``reads``."""
        own = stage(step.stage)
        taken: dict[str, list[Path]] = {need: [] for need in own.needs}
        taken_steps: list[Step] = []
        for need, item in inputs(self.campaign, step.stage, step.item):
            one = self.steps.get(f"{need}/{item}")
            taken_steps += [one] if one is not None else []
            if one is not None and one.status in DONE and one.at is not None:
                taken.setdefault(need, []).append(Path(one.at))
                if stage(need).folder is not None:
                    folder = self.folder(need, item)
                    paths = [f"{folder}/{each}" for each in artifacts.load(one.at).names]
                    step.reads.update((path, state_of(path)) for path in paths)
        files = own.files(self.campaign, step.item)
        return Given(
            item=step.item,
            settings={name: value_of(each) for name, each in own.settings(self.campaign, step.item).items()},
            files={role: tuple(map(Path, paths)) for role, paths in files.items()},
            inputs=taken,
            failures=self.failures(None if own.per == "study" else taken_steps) if own.tells_failures else (),
            folder=None if own.folder is None else own.folder(self.campaign, step.item),
        )

    def end(self, step: Step, status: str, message: str, *, final: bool, loaded: tuple[str, ...]) -> bool:
        """Record that a step has ended; whether it is to be tried again at once, as a file changed while it ran.

        Its key is made anew of what it used. A result is kept only if the files it was made from, and the code, are as
        they were before it ran.
        """
        unfinished = self.store.unfinished(step.id, step.key)
        changed = self._changed_meanwhile(step)
        imported = self._code.used(module_of(step.stage), step.types).modules.value
        code = self._use(step, tuple(name for name in loaded if name not in imported)).changed()
        if changed or code:
            unfinished.unlink(missing_ok=True)
            what = changed or f"The program's code changed ({code})"
            step.status, step.message = "failed", f"{what} while the step ran. Run the study again."
            return not code
        if status == "done":
            if stage(step.stage).folder is not None:
                old = self.store.results(step.id)
                remove_left_files(self.folder(step.stage, step.item), old, artifacts.load(unfinished))
            step.at = self.store.settle(unfinished, step.id, step.key)
            step.result = self.prints.file(step.at)
        step.status, step.message = status, message
        self._record(step, final=final)
        return False

    def _use(self, step: Step, loaded: tuple[str, ...]) -> Reached:
        """Give a step the key that it has with the code and libraries that it uses, and say which they are."""
        used = self._code.used(module_of(step.stage), (*step.types, *loaded))
        own = step.parts
        step.parts = Parts(own.settings, own.files, own.inputs, used.modules, used.libraries)
        step.key, step.loaded = _key(step.stage, step.item, step.parts), loaded
        return used

    def _changed_meanwhile(self, step: Step) -> str:
        for path, state in step.reads.items():
            if state_of(path) != state:
                self.prints.forget(path)
                return f"{path} changed"
        for need, item in inputs(self.campaign, step.stage, step.item):
            one = self.steps.get(f"{need}/{item}")
            if one is not None and one.at is not None and stage(need).folder is not None:
                trouble = artifacts.load(one.at).trouble(self.folder(need, item), self.prints)
                if trouble:
                    return f"{one.id} changed ({trouble})"
        return ""

    def _record(self, step: Step, *, final: bool) -> None:
        message = self._portable(step.message)
        parts, kernel = step.parts, blas_kernel()
        entry = Entry(step.id, step.key, step.status, message, final, step.result, parts, kernel, step.loaded)
        self.ledger.record(entry)

    def _portable(self, message: str) -> str:
        """A message as it is kept: a project that was moved or copied names its own files."""
        return message.replace(f"{self._base}{os.sep}", _PROJECT)

    def _here(self, message: str) -> str:
        return message.replace(_PROJECT, f"{self._base}{os.sep}") if message else ""

    def _step(self, name: str, item: str) -> Step:
        own = stage(name)
        known: dict[str, str] = {}
        unknown: list[str] = []
        blocked = ""
        for need, other in inputs(self.campaign, name, item):
            one = self.steps.get(source := f"{need}/{other}")
            if one is None:
                continue
            if one.status in DONE:
                known[source] = one.result
            elif one.status in REFUSED:
                known[source] = f"failed {digest(self._portable(one.message))}"
                blocked = source if own.per == "run" or (other == item and own.per != "study") else blocked
            else:
                unknown.append(source)
        reads: dict[str, FileState | None] = {}
        files: dict[str, str] = {}
        for paths in own.files(self.campaign, item).values():
            for path in map(str, paths):
                reads[path], files[_beside(path, self._base)] = self.prints.seen(path)
        settings, types = self._values.part(own.settings(self.campaign, item))
        step = Step(name, item, Parts(settings, files, known, _NOTHING, _NOTHING), "", reads=reads, types=types)
        self._use_as_before(step)
        if blocked:
            step.status, step.message = "blocked", f"{blocked} failed"
        elif unknown:
            step.key, last = "", self.ledger.last(step.id)
            reasons = () if last is None else tuple(differences(last.parts, step.parts, unknown))
            step.status = "stale" if reasons or last is None else "waits"
            step.reasons = reasons or (("never ran",) if last is None else tuple(f"input {one}" for one in unknown))
        else:
            self._look_up(step, own)
        return step

    def _use_as_before(self, step: Step) -> None:
        """Give a step the key that a kept entry has, if it uses today what it used then; else the one that it would
        have, did it use the same modules and libraries as last time."""
        below, name = self._below, step.id
        before = self.ledger.loaded(name) + (below.loaded(name) if below else []) or [()]
        for loaded in dict.fromkeys(before):
            self._use(step, loaded)
            if self.ledger.with_key(name, step.key) or (below and below.with_key(name, step.key)):
                return
        self._use(step, before[0])

    def _look_up(self, step: Step, own: Stage) -> None:
        """Status of a step whose key is known."""
        entry = self.ledger.with_key(step.id, step.key)
        if entry is not None and entry.status == "failed":
            step.status, step.message = "failed", self._here(entry.message)
            if not entry.final:
                step.status, step.reasons = "stale", (_AGAIN,)
            return
        trouble = ""
        if entry is not None:
            path = self.store.path(step.id, step.key)
            trouble = self._trouble(path, entry, own, step.item)
            if not trouble:
                step.status, step.message = "fresh", self._here(entry.message)
                step.result, step.at = entry.result, path
                return
        if self._found_below(step, own):
            step.status = "fresh"
            return
        last = self.ledger.last(step.id)
        if entry is not None and entry is last:
            step.reasons = (trouble,)
        else:
            step.reasons = ("never ran",) if last is None else tuple(differences(last.parts, step.parts)) or (_AGAIN,)

    def _trouble(self, path: str, entry: Entry, own: Stage, item: str) -> str:
        """What is wrong with a stored result, "" where nothing is."""
        found = self.prints.file(path)
        if found != entry.result:
            missing = "a folder is in place of its result" if os.path.isdir(path) else "its result is missing"
            return missing if found == "missing" else "its result was damaged"
        if own.folder is None:
            return ""
        try:
            written: WrittenFiles = artifacts.load(path)
        except artifacts.DamagedResult:
            return "its result was damaged"
        folder = own.folder(self.campaign, item)
        more = "" if own.alone_in is None else written.besides(folder, own.alone_in(self.campaign, item))
        return f"{more} is not of it" if more else written.trouble(folder, self.prints)

    def _found_below(self, step: Step, own: Stage) -> bool:
        """A result of the store below; files that a stage wrote there do not count here."""
        if self._below is None or (own.folder is not None and not self._reading):
            return False
        entry, path = self._below.with_key(step.id, step.key), self.store.path_below(step.id, step.key)
        if entry is None or path is None or entry.status != "done" or self._trouble(path, entry, own, step.item):
            return False
        step.result, step.at, step.message = entry.result, path, self._here(entry.message)
        return True

    def folder(self, name: str, item: str) -> Path:
        """Where a step of a stage that writes files writes them."""
        folder = stage(name).folder
        assert folder is not None
        return folder(self.campaign, item)


def _key(name: str, item: str, parts: Parts) -> str:
    shared = (parts.settings.digest, parts.code.digest, parts.libraries.digest)
    return digest(repr((name, item, shared, tuple(parts.files.items()), tuple(parts.inputs.items()))))


def _beside(path: str, base: str) -> str:
    """A path as seen from the study file, wherever the project lies; others as they are."""
    return (
        path[len(base) + 1 :].replace("\\", "/") if path.startswith(base) and path[len(base) :][:1] in "/\\" else path
    )


def open_step_plan(
    study: Study,
    stages: Iterable[str],
    warn: Callable[[str], None],
    *,
    below: Path | None = None,
    reading: bool = False,
    asked: Collection[str] = (),
) -> StepPlan:
    """The plan of a study, with its runs looked up where one of the ``stages`` needs them. Raises as ``campaign``."""
    found = campaign(study) if needs_runs(tuple(stages)) else Campaign(study)
    return StepPlan(found, Store(study.results, below), warn, reading=reading, asked=asked)


def memory_of_files(results: Path, warn: Callable[[str], None]) -> Fingerprints:
    """The fingerprints beside the results."""
    return Fingerprints(results / "fingerprints.json", warn)


def survey(
    study: Study,
    stages: Sequence[str],
    warn: Callable[[str], None],
    *,
    below: Path | None = None,
    asked: Collection[str] = (),
) -> StepPlan:
    """The state of all steps of the stages; nothing is computed, nothing but the fingerprint memory is written."""
    plan = open_step_plan(study, stages, warn, below=below, reading=True, asked=asked)
    for name in stages:
        plan.add_stage(name)
    plan.prints.save()
    return plan
