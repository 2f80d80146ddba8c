"""The steps of the whole study: hypotheses, profiles and schedules."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from emg2vsa import artifacts
from emg2vsa.errors import DataError
from emg2vsa.fits import Fits, concatenate
from emg2vsa.hypotheses import test_hypotheses
from emg2vsa.pipeline.tasks import Ended, guarded
from emg2vsa.profiles import build_profiles
from emg2vsa.schedules.build import build_schedules
from emg2vsa.study import Study

Inputs = Mapping[str, Sequence[Path]]


def hypotheses(study: Study, inputs: Inputs, result: Path) -> list[Ended]:
    """The tests on b."""
    return stored("hypotheses", result, lambda: test_hypotheses(_fits(inputs), study.hypotheses))


def profiles(study: Study, inputs: Inputs, result: Path) -> list[Ended]:
    """Mean trends and the new specimen's profile."""

    def make() -> object:
        use = study.hypotheses.use
        return build_profiles(_fits(inputs), study.stiffness_n_per_mm, study.profile, study.window, use)

    return stored("profiles", result, make)


def schedules(study: Study, inputs: Inputs, result: Path) -> list[Ended]:
    """Stiffness schedules of all exported specimens; they carry the digest of the profiles they come from."""

    def make() -> object:
        (path,) = inputs["profiles"] or (None,)
        if path is None:
            raise DataError("schedules", wanted="profiles", found="none", do="Mend what the profiles step reports.")
        provenance = {"study": study.name, "mode": study.mode, "profiles": path.stem}
        return build_schedules(artifacts.load(path), study.schedule, provenance)

    return stored("schedules", result, make)


def stored(stage: str, result: Path, make: Callable[[], object]) -> list[Ended]:
    return [guarded(f"{stage}/study", lambda: artifacts.save(result, make()))]


def _fits(inputs: Inputs) -> Fits:
    if not inputs["fits"]:
        raise DataError(
            "fits", wanted="the fits of at least one recording", found="none", do="Mend the recordings first."
        )
    return concatenate([artifacts.load(path) for path in inputs["fits"]])
