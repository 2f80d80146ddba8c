"""The worlds that studies are drawn from: what is true in them, and what scatters.

What scatters, and where the numbers are from:

- presses of a person: a and b share a factor of SD 5 % (``studies/palpation/study.toml``), and 22 force bins scatter by
  7.7 % of the level, as in the fits of the shipped demo; its b then scatters by 8 % from press to press
- presses and mountings of the rig, by condition: world N1 of ``benchmarks/results/control_scatter.json``
- the circle and the paper's hexagons, from press to press and by angle: ``casr_cv`` in the demo's table of algorithms
- first areas: 4.8 % a press (``benchmarks/results/emulated_scatter.json``)
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from emg2vsa.arrays import Floats

SPECIMENS = ("S1", "S2", "S3", "S4", "S5")
PRESSED = ("S1", "S_new", "S3", "S5")
KAPPA = np.array([7.63, 5.32, 3.35, 1.11])
"N/mm of ``PRESSED``."
DESIGNS = (
    *((condition, angle) for condition in ("high-stiffness", "modular") for angle in (0.0, 30.0, 45.0)),
    ("constant-min", 0.0), ("constant-mean", 0.0), ("constant-max", 0.0),
)  # fmt: skip
ALGORITHMS = ("front", "circle", "paper")
TRUE_ORDER = (0.0, 0.077, 0.270, 0.554)
"ln CASR of ``PRESSED`` over the stiffest, in the emulated world."
Law = Literal["normal", "t3", "lognormal"]
Order = Literal["random", "constant", "unknown"]
"Of specimens or mountings; unknown: at random, and nobody wrote it down."
_BENCH = json.loads((Path(__file__).resolve().parents[1] / "results" / "control_scatter.json").read_text())["N1"]


def on_compliance(softest_over_stiffest: float) -> tuple[float, ...]:
    """ln CASR of ``PRESSED`` on the law 1/kappa = a + b CASR^1.5, with this ln of the ratio of the outer two."""
    inverse = 1 / KAPPA
    ratio = np.exp(1.5 * softest_over_stiffest)
    offset = (inverse[-1] - ratio * inverse[0]) / (ratio - 1)
    return tuple((2 / 3 * np.log((inverse + offset) / (inverse[0] + offset))).tolist())


CURVE = on_compliance(0.367)
"That of the demo's front, on which 1 % of CASR is 9 % of kappa at 5.32 N/mm."


@dataclass(frozen=True)
class People:
    """b and a of the law v = a + b ln F in microvolts, and what scatters, as shares of them.

    a, b : of ``SPECIMENS``. person, person_by_specimen, press, bin : SDs. law : of presses (and of people by
    specimens). serial : autocorrelation of a person's presses. drift : over a session, in SDs of b of a press; the
    rates of people scatter by 30 %; steps : it moves from recording to recording, and not within them. order : of
    specimens. lost : share of presses that are rejected. unequal : SDs of people's presses lie between 1 / unequal and
    unequal times theirs. power_law : activity is a power of force in place of a logarithm.
    """

    a: tuple[float, ...] = (42.0, 36.0, 28.0, 27.0, 16.0)
    b: tuple[float, ...] = (20.0, 17.0, 13.0, 12.5, 7.0)
    people: int = 14
    presses: int = 10
    person: float = 0.0
    person_by_specimen: float = 0.0
    press: float = 0.05
    bin: float = 0.077
    law: Law = "normal"
    serial: float = 0.0
    drift: float = 0.0
    steps: bool = False
    order: Order = "random"
    lost: float = 0.0
    unequal: float = 1.0
    power_law: bool = False


@dataclass(frozen=True)
class Rig:
    """What is true of the rig's scores and what scatters, in natural logarithms.

    casr, area : of ``PRESSED``, rigid motor. contrast : by which human-like stiffness multiplies the ratio of the
    softest to the stiffest, and others in proportion. area_of_angle, casr_of_angle : at 0, 30 and 45 degrees.
    new_off : algorithm to the error of kappa of the new specimen that its CASR has, at each angle; human_like_off : the
    same with human-like stiffness, by all but the circle; None: as with the rigid motor. at_minimum : share of its
    distance to the stiffest that the new specimen has at the lowest constant stiffness.
    press, mounting : SDs; None: the bench's by condition. own_scatter : whether circle and hexagons scatter more than
    the front, as on the bench. cell : (design, specimen) that scatters ``more`` times as much; condition : the same of
    all cells of a condition. lost : share of presses without a score. drift : over all mountings, in SDs of a
    mounting, in their order. serial : of presses.
    """

    casr: tuple[float, ...] = CURVE
    contrast: float = 1.0
    human_like_off: tuple[float, ...] | None = None
    area: tuple[float, ...] = (0.0, 0.05, 0.16, 0.48)
    area_of_angle: tuple[float, float, float] = (0.0, -0.058, -0.139)
    casr_of_angle: tuple[float, float, float] = (0.0, -0.07, -0.15)
    new_off: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    at_minimum: float = 1.0
    mountings: int = 3
    presses: int = 3
    press: float | None = None
    mounting: float | None = None
    own_scatter: bool = True
    cell: tuple[int, int] | None = None
    condition: str = ""
    more: float = 1.0
    law: Law = "normal"
    serial: float = 0.0
    lost: float = 0.0
    drift: float = 0.0
    order: Order = "random"

    def scatter(self) -> tuple[Floats, Floats]:
        """SD of presses and of mountings of CASR by the front, (D, S)."""
        shape = (len(DESIGNS), len(PRESSED))
        press, mounting = np.empty(shape), np.empty(shape)
        for d, (condition, _) in enumerate(DESIGNS):
            press[d] = _BENCH[condition]["press_sd"] if self.press is None else self.press
            mounting[d] = _BENCH[condition]["mounting_sd"] if self.mounting is None else self.mounting
            if condition == self.condition:
                mounting[d] *= self.more
        if self.cell is not None:
            mounting[self.cell] *= self.more
        return press, mounting


@dataclass(frozen=True)
class World:
    """One world. effect : whether power is asked for in it, beside false verdicts. beyond : whether no data can tell
    what is true in it, so that it stands alone.
    """

    name: str
    says: str
    people: People
    rig: Rig
    effect: bool = False
    beyond: bool = False


_EQUAL = tuple(float(np.mean(People.b)) for _ in SPECIMENS)
_EQUAL_A = tuple(float(np.mean(People.a)) for _ in SPECIMENS)
SAME = People(a=_EQUAL_A, b=_EQUAL)
"No specimen differs."
DEMO = Rig()
"True order of specimens, nothing that a condition or an algorithm changes."
ALIKE = Rig(casr=(0.0,) * 4, area=(0.0,) * 4, area_of_angle=(0.0,) * 3, casr_of_angle=(0.0,) * 3)
"Nothing differs on the rig."
LONG = replace(DEMO, mountings=1, presses=10)
CROSSED = People(a=(42.0, 36.0, 42.0, 32.0, 16.0), b=(20.0, 17.0, 20.0, 15.0, 7.0), person_by_specimen=0.3, press=0.05)
"S1 and S3 are equal in the population, and people differ in their slopes by specimen."
PAIRED = replace(CROSSED, person_by_specimen=0.05)
"S1 and S3 are equal, and people hardly differ."
TWO_ALIKE = replace(DEMO, casr=(0.0, 0.0, 0.0, 0.55), area=(0.0, 0.0, 0.0, 0.48))


def _paper(share: float) -> tuple[People, Rig]:
    """What the paper reports, ``share`` of its differences; errors of kappa are the paper's in any case.

    Human-like stiffness multiplies the contrast by 1.12; areas and rates fall with the angle, and areas of specimens
    are alike; kappa of the new specimen is 25 % off by the circle (6 % at 0 degrees), and 7 to 13 % by hexagons and
    front with the rigid motor, 3 to 4 % with human-like stiffness; the lowest constant stiffness hardly tells it from
    its stiffer neighbour; b of specimens is that of the demo.
    """
    b, a = np.array(People.b), np.array(People.a)
    rig = Rig(
        casr=on_compliance(0.554 * share), contrast=1 + 0.12 * share, area=(0.0,) * 4,
        area_of_angle=(0.0, -0.15 * share, -0.30 * share), casr_of_angle=(0.0, -0.07 * share, -0.15 * share),
        new_off={"circle": (0.06, 0.25, 0.28), "front": (0.05, 0.07, 0.13), "paper": (0.05, 0.07, 0.13)},
        human_like_off=(0.03, 0.03, 0.04), at_minimum=0.3,
    )  # fmt: skip
    pull = np.clip(share, 0, 1)
    return People(
        a=tuple((a.mean() + pull * (a - a.mean())).tolist()), b=tuple((b.mean() + pull * (b - b.mean())).tolist())
    ), rig


_PEOPLE, _RIG = _paper(1.0)
_HALF, _HALF_RIG = _paper(0.5)
_, _TWICE_RIG = _paper(2.0)
_FAR = replace(_RIG, casr=on_compliance(1.108), contrast=1.0, own_scatter=False, mounting=0.02)


def _at_margins(share: float) -> tuple[People, Rig]:
    """Every estimand that can be is ``share`` of its margin: claims are decided wrongly most easily there."""
    b2, b4, off = 17.2, 13.0 - 1.333 * share, 0.2 * share
    level = 1 + 0.1 * share / (1 - 0.1 * share)  # of the profile of S2 at 7 N over that of its neighbours there
    a2 = 65.9 * level - b2 * float(np.log(7))
    people = People(a=(42.0, a2, 28.0, 25.0, 16.0), b=(20.0, b2, 13.0, b4, 7.0), person=0.25 * share * 0.068)
    step = float(np.log1p(0.05 * share))
    rig = replace(
        _FAR, contrast=1 + 0.05 * share, area=(0.0, step / 3, step / 2, step),
        area_of_angle=(0.0, -step, -2 * step), new_off=dict.fromkeys(ALGORITHMS, (off,) * 3), human_like_off=(off,) * 3,
    )  # fmt: skip
    return people, rig


WORLDS = (
    World("alike", "nothing differs", SAME, ALIKE),
    World("order", "specimens differ, no condition, no algorithm does", People(), replace(DEMO, casr=TRUE_ORDER)),
    World("one-mounting", "one mounting of ten presses, mountings 2.7 %", People(), replace(LONG, mounting=0.027)),
    World("one-mounting-4.3", "one mounting of ten presses, mountings 4.3 %", SAME, replace(LONG, mounting=0.043)),
    World("mountings-4.3", "mountings 4.3 %", People(person=0.1), replace(DEMO, mounting=0.043)),
    World("mountings-6", "mountings 6 %, all alike", SAME, replace(ALIKE, mounting=0.06)),
    World("cell-6x", "one cell of the rig scatters 6 times as much", SAME, replace(DEMO, cell=(3, 3), more=6.0)),
    World("condition-6x", "one condition scatters 6 times as much", People(),
          replace(DEMO, condition="modular", more=6.0)),
    World("drift-constant", "drift of 4 SD, the same order for all: b falls and CASR rises where the claims want it",
          replace(PAIRED, drift=-4.0, order="constant"), replace(TWO_ALIKE, drift=4.0, order="constant")),
    World("drift-1", "the same, drift of 1 SD", replace(PAIRED, drift=-1.0, order="constant"),
          replace(TWO_ALIKE, drift=1.0, order="constant")),
    World("drift-steps", "drift of 4 SD from recording to recording of people, none within, the same order for all",
          replace(PAIRED, drift=-4.0, order="constant", steps=True), TWO_ALIKE, beyond=True),
    World("drift-random", "drift of 4 SD, orders at random", replace(PAIRED, drift=-4.0), replace(ALIKE, drift=4.0)),
    World("drift-unknown", "drift of 4 SD, orders at random that nobody wrote down",
          replace(PAIRED, drift=-4.0, order="unknown"), replace(TWO_ALIKE, drift=4.0, order="unknown")),
    World("lost", "a fifth of all presses lost, two specimens alike", replace(PAIRED, lost=0.2),
          replace(TWO_ALIKE, lost=0.2)),
    World("crossed-14", "S1 = S3 on average, people differ by 30 % a specimen", CROSSED, TWO_ALIKE),
    World("crossed-3", "the same, 3 people", replace(CROSSED, people=3), replace(TWO_ALIKE, mounting=0.043)),
    World("t3", "Student's t with 3 df for presses, people and mountings",
          replace(SAME, law="t3", person=0.1, person_by_specimen=0.1), replace(ALIKE, law="t3")),
    World("lognormal", "skewed presses, people and mountings",
          replace(SAME, law="lognormal", press=0.25, person_by_specimen=0.15),
          replace(ALIKE, law="lognormal", mounting=0.06)),
    World("serial", "presses autocorrelated by .7", replace(SAME, serial=0.7, press=0.08), replace(DEMO, serial=0.7)),
    World("two-alike", "S1 = S_new = S3 on the rig; presses of people scatter by 1/2 to 2 times",
          replace(SAME, unequal=2.0), TWO_ALIKE),
    World("reductions-null", "hexagons, circle and human-like stiffness are all 10 % off; specimens are far apart",
          _PEOPLE, replace(_FAR, new_off=dict.fromkeys(ALGORITHMS, (0.1,) * 3), human_like_off=(0.1,) * 3)),
    World("kappa-wrong", "the same, all 40 % off", _PEOPLE,
          replace(_FAR, new_off=dict.fromkeys(ALGORITHMS, (0.4,) * 3), human_like_off=(0.4,) * 3)),
    World("margins-within", "whatever can be lies 5 % within its margin", *_at_margins(0.95)),
    World("margins-beyond", "whatever can be lies 5 % beyond its margin", *_at_margins(1.05)),
    World("paper", "the paper's effects, circle and hexagons scatter as on the bench", _PEOPLE, _RIG, effect=True),
    World("paper-front", "the paper's effects, all algorithms scatter as the front", _PEOPLE,
          replace(_RIG, own_scatter=False), effect=True),
    World("half", "half of the paper's effects", _HALF, replace(_HALF_RIG, own_scatter=False), effect=True),
    World("twice", "twice the paper's effects on the rig", _PEOPLE,
          replace(_TWICE_RIG, own_scatter=False), effect=True),
    World("wrong-profile", "the profile of S2 lies 30 % beside its neighbours' line",
          replace(_PEOPLE, a=(42.0, 48.0, 28.0, 27.0, 16.0), b=(20.0, 22.5, 13.0, 12.5, 7.0)), DEMO, effect=True),
    World("power-law", "activity is a power of force", replace(_PEOPLE, power_law=True), DEMO, effect=True),
    World("people-differ", "people differ by 15 %; mountings 1 %", replace(_PEOPLE, person=0.15),
          replace(_RIG, mounting=0.01, press=0.01), effect=True),
    World("six-mountings", "the paper's effects, 6 mountings of 3", _PEOPLE,
          replace(_RIG, mountings=6, own_scatter=False), effect=True),
)  # fmt: skip
