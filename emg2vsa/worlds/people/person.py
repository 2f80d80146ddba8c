"""Who is emulated: specimens with their true coefficients, and the habits of a hand."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from emg2vsa.errors import SettingError
from emg2vsa.study import Study
from emg2vsa.worlds.people.recording import JOIN_SHARE, REST_SHARE, check_coefficients, spread

USUAL_STIFFNESS_N_PER_MM = 3.0
"Of a specimen whose stiffness the study does not say."


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
    usual: Response = field(init=False)

    def __post_init__(self) -> None:
        known = list(self.responses.values())
        a_v, b_v = (float(np.mean([getattr(r, name) for r in known])) for name in ("a_v", "b_v"))
        object.__setattr__(self, "usual", Response(a_v, b_v, USUAL_STIFFNESS_N_PER_MM))

    @property
    def join_n(self) -> float:
        """Force at which the logarithm ends."""
        return JOIN_SHARE * self.lower_n

    @property
    def rest_v(self) -> float:
        """Tone of the resting muscles: one for all specimens, for a hand at rest does not know what lies before it."""
        return REST_SHARE * min(r.a_v + r.b_v * math.log(self.join_n) for r in self.responses.values())

    @property
    def contraction_v(self) -> float:
        """Level of a maximum voluntary contraction."""
        return self.contraction_factor * max(r.a_v + r.b_v * math.log(7.0) for r in self.responses.values())


def person_of(study: Study, participant: str) -> Person:
    """The participant as ``emg2vsa tools simulate`` would record them: same seed, same a and b of every specimen.

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
    index = study.participants.index(participant)
    # the draw of emg2vsa.worlds.people.plan, so that both tell the same truth of a participant
    rng = np.random.default_rng(np.random.SeedSequence(settings.seed, spawn_key=(index,)))
    factor = float(spread(rng, settings.participant_sd, 1)[0])
    lower_n = study.window.force_n[0]
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
        seed=(settings.seed, index),
        repetition_sd=settings.repetition_sd,
        emg_noise_v=settings.emg_noise_v,
        mains_v=settings.mains_v,
        mains_hz=settings.mains_hz,
        force_noise_n=settings.force_noise_n,
    )
