"""Presses beside each other: one whose skin stretched otherwise is named, presses that are alike are not."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest

from casr.doubts import Stretch, stretch_of, unlike_others
from casr.scoring import Score, score
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, TimelineSettings, simulate_press


@cache
def pressed(specimen: str, stick_force_n: float | None, repetition: int = 0) -> Score:
    """In the world that sticks up to a force, or by finite elements."""
    timeline = TimelineSettings(loading_s=1.5)
    settings = PressSettings(stiffness_n_per_mm=SPECIMENS[specimen], repetition=repetition, timeline=timeline)
    if stick_force_n is not None:
        settings = dataclasses.replace(settings, world=ContactWorld(stick_force_n=stick_force_n))
    return score(simulate_press(settings).sequence())


def stretches(**presses: tuple[str, float | None, int]) -> dict[str, Stretch]:
    found = {name: stretch_of(pressed(*how)) for name, how in presses.items()}
    assert all(found.values())
    return {name: stretch for name, stretch in found.items() if stretch is not None}


ALIKE = {"a": ("S1", 1.0, 0), "b": ("S3", 1.0, 0), "c": ("S5", 1.0, 0), "d": ("S3", 1.0, 1)}


@pytest.mark.parametrize("stick_force_n", [None, 1.0])
def test_presses_that_are_alike_are_not_named(stick_force_n: float | None) -> None:
    alike = {name: (specimen, stick_force_n, repetition) for name, (specimen, _, repetition) in ALIKE.items()}
    assert unlike_others(stretches(**alike)) == {}


@pytest.mark.parametrize("specimen", ["S1", "S3", "S5"])
@pytest.mark.parametrize(("own_n", "others_n"), [(0.5, 1.0), (2.0, 1.0)])
def test_another_stick_force_is_named(specimen: str, own_n: float, others_n: float) -> None:
    presses = {name: (kind, others_n, repetition) for name, (kind, _, repetition) in ALIKE.items()}
    found = unlike_others(stretches(**presses, odd=(specimen, own_n, 1)))
    assert list(found) == ["odd"]
    for word in ("skin grew", "standard errors", "slip", "friction", "lost pins"):
        assert word in found["odd"]


def test_lost_pins_that_take_the_skin_with_them_are_named() -> None:
    """The pins of the region stand still in the last frames: mistaken for dirt, say."""
    whole = pressed("S3", 1.0, 2)
    growth = whole.log_growth.copy()
    growth[len(growth) // 4 :] = 0.0
    lost = stretch_of(dataclasses.replace(whole, log_growth=growth))
    good = stretch_of(whole)
    assert lost is not None
    assert good is not None
    assert list(unlike_others({**stretches(**ALIKE), "lost": lost})) == ["lost"]
    assert unlike_others({**stretches(**ALIKE), "good": good}) == {}


def flat(log_ratio: float, low_n: float = 0.5, high_n: float = 7.0, log_sd: float = 0.05) -> Stretch:
    force_n = np.linspace(low_n, high_n, 20)
    return Stretch(force_n, log_ratio * np.log(force_n / low_n) / np.log(high_n / low_n), log_sd)


def test_the_forces_are_those_in_common() -> None:
    """One that stops early fell as much by then as the others had, and is not named."""
    low = {name: flat(-1.0) for name in "abc"}
    share = np.log(2 / 0.5) / np.log(7 / 0.5)
    assert unlike_others({**low, "early": flat(-share, high_n=2.0)}) == {}
    assert list(unlike_others({**low, "early": flat(-1.0, high_n=2.0)})) == ["early"]
    assert unlike_others({**low, "short": flat(-1.0, high_n=0.7)}) == {}, "too little in common"


def test_three_presses_name_nobody() -> None:
    assert unlike_others({"a": flat(-1.0), "b": flat(-1.0), "c": flat(-3.0)}) == {}
    assert unlike_others({}) == {}


def test_its_own_error_counts_and_so_does_the_others_scatter() -> None:
    others = {name: flat(-1.0) for name in "abcd"}
    assert list(unlike_others({**others, "odd": flat(-1.25)})) == ["odd"]
    assert "odd" not in unlike_others({**others, "odd": flat(-1.25, log_sd=0.2)})
    scattered = {name: flat(value) for name, value in zip("abcd", (-0.6, -0.9, -1.1, -1.4), strict=True)}
    assert "odd" not in unlike_others({**scattered, "odd": flat(-1.25)})


def test_a_press_without_forces_or_front_has_no_stretch() -> None:
    whole = pressed("S3", 1.0, 2)
    assert stretch_of(dataclasses.replace(whole, force_n=None)) is None
    assert stretch_of(dataclasses.replace(whole, front_spread=None)) is None


def test_two_presses_are_compared_once(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(5)
    made = {
        str(k): Stretch(np.sort(rng.uniform(0.5, 7, 20)), np.cumsum(rng.uniform(0, 0.1, 20)), 0.05) for k in range(6)
    }
    before, between, calls = unlike_others(made), Stretch.between, []
    monkeypatch.setattr(Stretch, "between", lambda self, *ends: calls.append(ends) or between(self, *ends))
    assert unlike_others(made) == before
    assert len(calls) == 6 * 5
