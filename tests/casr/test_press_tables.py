"""Tables of a press: what stands in them is what was scored."""

from __future__ import annotations

import csv
import dataclasses
import io

import numpy as np
import pytest

from casr.frames import FrameSequence, force_per_frame
from casr.press_tables import frame_columns, frame_rows, frames_csv, pins_csv
from casr.scoring import Score, score
from emg2vsa.worlds.tactile import PressSettings, TimelineSettings, simulate_press


@pytest.fixture(scope="module")
def scored() -> Score:
    press = simulate_press(PressSettings(stiffness_n_per_mm=7.63, timeline=TimelineSettings(loading_s=1.5)))
    log = press.timeline
    force_n = force_per_frame(log.log_force_n, log.log_frame_index, len(press.frames))
    return score(FrameSequence(press.frames, press.settings.camera, force_n))


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_every_pin_of_every_frame(scored: Score) -> None:
    found = rows(pins_csv(scored))
    n_pins = len(scored.rest)
    assert len(found) == n_pins * (1 + len(scored.frames))
    assert [int(row["frame"]) for row in found[::n_pins]] == [scored.rest_frame, *scored.frames]
    last = found[-n_pins:]
    assert [int(row["pin"]) for row in last] == list(range(n_pins))
    places = np.array([(float(row["x_px"]), float(row["y_px"])) for row in last])
    assert places == pytest.approx(scored.pins_px[-1], abs=5e-4)
    assert sum(int(row["inside"]) for row in last) == scored.front.pins_inside[-1]
    assert not any(int(row["inside"]) for row in found[:n_pins])


def test_a_lost_pin_is_empty(scored: Score) -> None:
    places = scored.pins_px.copy()
    places[-1, 7] = np.nan
    row = rows(pins_csv(dataclasses.replace(scored, pins_px=places)))[-len(scored.rest) + 7]
    assert (row["pin"], row["x_px"], row["y_px"]) == ("7", "", "")


def test_every_frame_with_its_interval(scored: Score) -> None:
    found = rows(frames_csv(scored))
    assert tuple(found[0]) == frame_columns("mm2")
    assert len(found) == len(scored.frames)
    area, low, high = (np.array([float(row[f"front_area{end}_mm2"]) for row in found]) for end in ("", "_low", "_high"))
    assert area == pytest.approx(scored.front.area, rel=1e-6)
    assert np.log(high / area) == pytest.approx(np.log(area / low), abs=1e-5)
    assert np.log(high / area) == pytest.approx(1.959964 * scored.front.relative_sd, rel=1e-3)
    assert [float(row["force_n"]) for row in found] == pytest.approx(scored.force_n, abs=1e-6)
    assert [float(row["skin_area_mm2"]) for row in found] == pytest.approx(scored.skin.area, rel=1e-6)
    assert [int(row["determined"]) for row in found] == scored.front.determined.astype(int).tolist()
    assert 0 < sum(int(row["determined"]) for row in found) < len(found), "the press begins too small"
    assert [float(row["shear_x_px"]) for row in found] == pytest.approx(scored.front.shear_px[:, 0], abs=1e-6)
    assert [float(row["torsion_deg"]) for row in found] == pytest.approx(scored.front.torsion_deg, abs=1e-6)


def test_what_is_not_known_is_empty_and_a_doubted_front_is_not_determined(scored: Score) -> None:
    doubted = dataclasses.replace(scored, force_n=None, front_doubt="too small", front_spread=None)
    assert {row[1] for row in frame_rows(doubted)} == {None}
    assert {row[-1] for row in frame_rows(doubted)} == {0}
    assert frames_csv(doubted).splitlines()[1].split(",")[1] == ""


def test_json_leaves_trajectories_to_the_table(scored: Score) -> None:
    found = scored.to_dict()
    assert "pins_px" not in found
    assert "inside" not in found["front"]
    assert len(found["contact_px"]) == len(scored.rest)
    assert found["rate"]["scatter_low"] > found["interval"]["low"], "the narrow interval goes by its name"
