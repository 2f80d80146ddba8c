"""How unlike the tables of a dome are to those of others, which its page tells."""

from __future__ import annotations

from pathlib import Path

from casr.dome.library import DEFAULT_WORLD, shipped, worlds
from casr.dome.tables import read_table
from casr.page.dome_page import unlikeness


def test_a_dome_is_like_itself_and_near_its_neighbours(lab: Path) -> None:
    """Dome A lies between J and H."""
    table = read_table(lab / "mine_k5.3_stick.npz")
    itself, near = unlikeness(table, shipped(DEFAULT_WORLD)), unlikeness(table, worlds())
    assert itself.dome == "A"
    assert itself.worst < 0.005
    assert near.dome == "J+H"
    assert 0.005 < near.worst < 0.05


def test_a_dome_of_another_stiffness_is_unlike(lab: Path) -> None:
    hard = shipped().only(shipped().dome == "G")
    assert unlikeness(read_table(lab / "mine_krigid_stick.npz"), hard).worst > 0.1
