"""Who is simulated: specimens with their true coefficients, what muscles do at a force, and the habits of a hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import SettingError
from emg2vsa.settings import SimulationSettings
from emg2vsa.study import Study

FloatArray = NDArray[np.float64]
Level = TypeVar("Level", float, FloatArray)

JOIN_SHARE = 0.6
"The logarithm ends at this share of the lower force of the window (0.3 N of 0.5 N)."
REST_SHARE = 0.2
"Rest tone, as a share of the co-contraction where the logarithm ends."
_VISITS = 1000
"First address of random numbers of later visits; those below are streams of a first visit."
USUAL_STIFFNESS_N_PER_MM = 3.0
"Stiffness of a specimen for which the study states none."


class Response(NamedTuple):
    """A specimen and what the muscles do on it: v = a + b ln(F / 1 N), volts."""

    a_v: float
    b_v: float
    stiffness_n_per_mm: float


@dataclass(frozen=True, kw_only=True)
class Person:
    """An emulated participant.

    responses : name of a specimen to the person's coefficients; any other specimen gets ``usual``. lower_n : lower
    force of the study's window; the logarithm ends at 0.6 of it. muscle_share : muscle to its share of the
    co-contraction. repetition_sd : relative spread of a and b between presses.
    reaction_s, rise_n_per_s, release_n_per_s : range of reaction times; of the rates of force; and of lifting.
    electromechanical_delay_s : from EMG to force.
    contraction_factor : maximum contraction, as a multiple of the largest co-contraction at 7 N.
    """

    name: str
    responses: dict[str, Response]
    muscle_share: dict[str, float]
    lower_n: float = 0.5
    seed: tuple[int, ...] = (1,)
    repetition_sd: float = 0.05
    emg_noise_v: float = 1.2e-6
    mains_v: float = 5e-7
    mains_hz: float = 50.0
    force_noise_n: float = 0.02
    reaction_s: tuple[float, float] = (0.25, 0.35)
    rise_n_per_s: tuple[float, float] = (2.0, 3.0)
    release_n_per_s: float = 10.0
    electromechanical_delay_s: float = 0.0
    contraction_factor: float = 4.0

    @cached_property
    def usual(self) -> Response:
        """On a specimen that the study does not know: the mean of the others."""
        a_v, b_v, _ = np.mean(list(self.responses.values()), axis=0).tolist()
        return Response(a_v, b_v, USUAL_STIFFNESS_N_PER_MM)

    @property
    def rest_v(self) -> float:
        """Tone of the resting muscles, V: one for all specimens, for a hand at rest does not know what lies before
        it."""
        return REST_SHARE * min(logarithm_end(r.a_v, r.b_v, self.lower_n)[1] for r in self.responses.values())

    @property
    def contraction_v(self) -> float:
        """Level of a maximum voluntary contraction, V."""
        return self.contraction_factor * max(r.a_v + r.b_v * math.log(7.0) for r in self.responses.values())


def person_of(study: Study, participant: str) -> Person:
    """The participant as ``emg2vsa tools simulate`` would record them: same seed, and at every visit same a and b.

    SettingError where the study has no [simulation], no such participant, or coefficients that make no sense.
    """
    settings = study.simulation
    if settings is None:
        raise SettingError(
            f"{study.path}, [simulation]",
            wanted="the true coefficients of the emulated participant",
            found="no such table",
            do="Add a table [simulation] with a_v and b_v of every specimen.",
        )
    if participant not in study.participants:
        raise SettingError(
            f"--participant {participant}",
            wanted=f"a participant of {study.path}",
            found=f"{', '.join(study.participants) or 'none'}",
            do="Choose one of these, or add the code to [participants].",
        )
    index, later = study.participants.index(participant), (study.visits or ("",)).index(study.visit)
    factor, lower_n = participant_factor(settings, index)[0], study.window.force_n[0]
    responses = {}
    for specimen in study.specimens:
        a_v, b_v = settings.a_v[specimen.name] * factor, settings.b_v[specimen.name] * factor
        check_coefficients(f"{study.path}, simulation, specimen {specimen.name}", a_v, b_v, lower_n)
        responses[specimen.name] = Response(a_v, b_v, specimen.stiffness_n_per_mm or USUAL_STIFFNESS_N_PER_MM)
    return Person(
        name=participant,
        responses=responses,
        muscle_share=dict(settings.muscle_share),
        lower_n=lower_n,
        seed=(settings.seed, index, *((_VISITS + later,) if later else ())),
        repetition_sd=settings.repetition_sd,
        emg_noise_v=settings.emg_noise_v,
        mains_v=settings.mains_v,
        mains_hz=settings.mains_hz,
        force_noise_n=settings.force_noise_n,
    )


def participant_factor(settings: SimulationSettings, index: int) -> tuple[float, np.random.Generator]:
    """Factors by which a and b of participant number ``index`` differ from those of the study; and the draws that
    follow.
    """
    # a seed is an address, so a recording does not depend on how many others there are
    rng = np.random.default_rng(np.random.SeedSequence(settings.seed, spawn_key=(index,)))
    return float(spread(rng, settings.participant_sd, 1)[0]), rng


def spread(rng: np.random.Generator, relative_sd: float, n: int) -> FloatArray:
    """(n,) factors around 1; a wide spread is cut at 0.1, for a co-contraction stays positive."""
    factors: FloatArray = np.maximum(1 + relative_sd * rng.standard_normal(n), 0.1)
    return factors


def cocontraction_v(
    force_n: FloatArray, a_v: Level, b_v: Level, lower_n: float, rest_v: float | None = None
) -> FloatArray:
    """Equation (6), v = a + b ln F, for F >= 0.6 ``lower_n``; below, a power of F, equal in value and slope there.

    force_n : (n,) true force, not negative. a_v, b_v : of all, or (n,). rest_v : at zero force; None: a fifth of the
    joint value. Returns (n,) volts.
    """
    join_n, join_v = logarithm_end(a_v, b_v, lower_n)
    at_rest = REST_SHARE * join_v if rest_v is None else rest_v
    exponent = b_v / (join_v - at_rest)
    below = at_rest + (join_v - at_rest) * (np.minimum(force_n, join_n) / join_n) ** exponent
    return np.where(force_n >= join_n, a_v + b_v * np.log(np.maximum(force_n, join_n)), below)


def logarithm_end(a_v: Level, b_v: Level, lower_n: float) -> tuple[float, Level]:
    """Force, N, and co-contraction, V, at which the logarithm (paper, eq. 6) ends. lower_n : of the study's window."""
    join_n = JOIN_SHARE * lower_n
    return join_n, a_v + b_v * math.log(join_n)


def check_coefficients(where: str, a_v: float, b_v: float, lower_n: float) -> None:
    """SettingError for a logarithm that is not rising, or not positive, V, where it ends. lower_n : of the study's
    window, N."""
    join_n, join_v = logarithm_end(a_v, b_v, lower_n)
    if not (b_v > 0 and join_v > 0):
        raise SettingError(
            where,
            wanted=f"b_v > 0 and a_v + b_v ln({join_n:g} N) > 0, so that EMG rises with force and stays positive",
            found=f"a_v = {a_v:g}, b_v = {b_v:g}, which give {join_v:.3g} V at {join_n:g} N",
            do="Raise a_v or lower b_v.",
        )
