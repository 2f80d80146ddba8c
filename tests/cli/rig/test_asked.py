"""What the person at the terminal is asked while a rig is set up."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from emg2vsa.cli.rig import commission
from emg2vsa.cli.rig.commission import Asked


def answered(monkeypatch: pytest.MonkeyPatch, *said: str) -> Iterator[str]:
    """The answers that are still to come."""
    left = iter(said)
    monkeypatch.setattr(commission, "answer", lambda question: next(left))
    return left


@pytest.mark.parametrize(
    ("said", "moved_mm"), [(["3.2"], 3.2), (["3,2"], 3.2), (["far", "3.2"], 3.2), ([""], None), (["far", ""], None)]
)
def test_a_distance_is_taken_with_point_or_comma_and_asked_again_where_it_is_no_number(
    said: list[str], moved_mm: float | None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    left = answered(monkeypatch, *said)
    assert Asked(nobody=False).moved_mm(20.0) == moved_mm
    assert next(left, None) is None
    assert ("Type a number of millimetres" in capsys.readouterr().out) is (said[0] == "far")


@pytest.mark.parametrize(("said", "towards"), [(["y"], True), (["No"], False), (["perhaps", "yes"], True)])
def test_a_direction_is_asked_for_until_it_is_yes_or_no(
    said: list[str], towards: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    answered(monkeypatch, *said)
    assert Asked(nobody=False).towards(5.0) is towards


def test_nobody_is_asked_with_yes(monkeypatch: pytest.MonkeyPatch) -> None:
    answered(monkeypatch)
    nobody = Asked(nobody=True)
    nobody.zero_calliper()
    assert nobody.towards(5.0) is nobody.moved_mm(20.0) is None
