"""What the functions of casr refuse, and in which words: one row for each."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import cv2
import numpy as np
import pytest

from benchmarks.tactile.flow_pairs import linear_pair
from benchmarks.tactile.press_scores import ArrayFrames
from casr.camera import Camera, Sensor
from casr.camera_calibration import Charuco, Chessboard
from casr.contact_area import AS_PRINTED, RULES, initial_area
from casr.errors import (
    AreaError,
    CameraError,
    CasrError,
    FramesError,
    ImageError,
    NoContactError,
    PinsError,
    SettingError,
)  # fmt: skip
from casr.flow.dense_engine import dis_flow
from casr.flow.estimate import FlowSettings, FlowTracker
from casr.flow.horn_schunck import HornSchunck, HornSchunckSettings, horn_schunck
from casr.flow.pin_engine import fit_affine
from casr.flow.region import Affine, Region
from casr.frames import FrameSequence, check_newtons, force_per_frame, loading_phase
from casr.images import as_grey
from casr.pins import Pins, PinSettings, PinTracker, detect_pins, pins_in_doubt
from casr.scoring import ScoreSettings, score
from casr.spread import RATE_RULES, contact_areas, spread_rate
from emg2vsa.worlds.tactile import TACTIP_127

Row = tuple[Callable[[], object], type[CasrError], str]
PINS = TACTIP_127.pins_px((149.5, 149.5))
AT_REST = Pins(centroids_px=PINS, area_px=np.full(len(PINS), 64.0), notes=())
FRAMES = np.arange(4 * 3 * 5, dtype=np.uint8).reshape(4, 3, 5)
BLANK, STILL = np.zeros((50, 60), np.uint8), np.zeros((4, 300, 300), np.uint8)
NAN, INF = float("nan"), float("inf")
PRESS = [0.0, 0.01, -0.01, 0.0, 0.2, 0.4, 0.6, 2.0, 4.0, 7.0, 5.0, 1.0, 0.2, 0.0]
TIME_S, INDEX, FRAME_S = np.arange(0, 80) / 200, np.repeat(np.arange(8), 10), np.arange(8) / 20
ON_A_DISC = FlowTracker(FlowSettings(engine="dis"))
SOME = linear_pair(1.0).first


def each(call: Callable[[Any], object], values: Iterable[object], error: type[CasrError], said: str) -> list[Row]:
    """The same of several values."""
    return [(partial(call, value), error, said) for value in values]


def settings(kind: Callable[..., object], error: type[CasrError], said: str = "{}", **wrong: object) -> list[Row]:
    """A setting with values that make no sense, several in a list; its name is said."""
    return [
        (partial(kind, **{name: value}), error, said.format(name))
        for name, values in wrong.items()
        for value in (values if isinstance(values, list) else [values])
    ]


def spoilt(value: float) -> np.ndarray:
    image = np.zeros((3, 4))
    image[1, 2] = value
    return image


def specks() -> np.ndarray:
    frame = np.zeros((600, 600), np.uint8)
    frame[5:-5:8, 5:-5:8] = 255
    return cv2.dilate(frame, np.ones((3, 3), np.uint8))


def started(tracker: Any, *first: object) -> Any:
    tracker.start(*first)
    return tracker


def moved(row: int, by_px: float) -> np.ndarray:
    contact = PINS.copy()
    contact[row] += (0.0, by_px)
    return contact


def times(frame_time_s: np.ndarray) -> np.ndarray:
    return force_per_frame(TIME_S, INDEX, 8, time_s=TIME_S, frame_time_s=frame_time_s, where="rig.csv")


BOARDS: list[Row] = [
    (lambda: Chessboard(2, 5, 4.0), SettingError, "--chessboard: expected 3 to 100 inner corners .*, but found 2x5"),
    (lambda: Chessboard(7, 101, 4.0), SettingError, "--chessboard"),
    (lambda: Chessboard(7, 5, 0.0), SettingError, "--square-mm: expected a length above 0 mm, but found 0"),
    (lambda: Charuco(7, 5, NAN, 1.0), SettingError, "--square-mm"),
    (lambda: Charuco(7, 5, 4.0, -1.0), SettingError, "--marker-mm: expected a length above 0"),
    (lambda: Charuco(7, 5, 4.0, 4.0), SettingError, "--marker-mm: expected less than the square, 4 mm, but found 4 mm"),
    (lambda: Charuco(2, 5, 4.0, 3.0), SettingError, "--charuco: expected 3 to 100 squares each way"),
    (lambda: Charuco(7, 5, 4.0, 3.0, "4X4"), SettingError, "--dictionary: expected one of 4X4_50, .* found '4X4'"),
    (lambda: Charuco(15, 10, 4.0, 3.0), SettingError, "--dictionary: expected at least 75 markers"),
]
CAMERAS: list[Row] = [
    *settings(
        Camera, CameraError, "camera.{}: expected", width_px=[0, 300.0], height_px=True, fx_px=-1.0, fy_px="300",
        cx_px=NAN, depth_mm=0.0, frame_rate_hz=INF,
        distortion=[(0.1,), (0.1, 0.2, "x", 0.0), 0.1, "0000", (0.1, 0.2, NAN, 0.0)],
    ),
    *settings(
        Sensor, CameraError, "sensor.{}: expected", pin_length_mm=[0.0, "1.5", True, (1.0,)],
        dome_radius_mm=[-20.0, INF, 0, NAN],
    ),
    (lambda: Camera(sensor={"pin_length_mm": 1.5}), CameraError,  # type: ignore[arg-type]
     r"camera.sensor: expected a Sensor, but found \{'pin_length_mm': 1.5\}"),
]  # fmt: skip
IMAGES: list[Row] = [
    *each(as_grey, [
        np.zeros((0, 5), np.uint8), np.zeros(5, np.uint8), np.zeros((2, 3, 2), np.uint8),
        np.zeros((1, 2, 3, 3), np.uint8), np.float64(3), np.zeros((2, 2), np.int32), np.zeros((2, 2), complex),
        np.full((2, 2), "a"),
    ], ImageError, "expected"),
    *each(lambda value: as_grey(spoilt(value), where="press.npy, frame 7"), [NAN, INF, -INF, 1e300], ImageError,
          "press.npy, frame 7.*1 of 12 values NaN or infinite"),
]  # fmt: skip
SEQUENCES: list[Row] = [
    *each(FrameSequence(ArrayFrames(FRAMES)).__getitem__, [4], FramesError, "a frame from 0 to 3, but found frame 4"),
    *each(FrameSequence(ArrayFrames(FRAMES)).__getitem__, [-5], FramesError, "a frame from 0 to 3, but found frame -5"),
    (lambda: FrameSequence(ArrayFrames(FRAMES), Camera(width_px=3, height_px=5)), CameraError,
     "3 x 5 px, but found frames of 5 x 3 px"),
    (lambda: FrameSequence(ArrayFrames(FRAMES), force_n=np.zeros(5)), FramesError, "one force for each of the 4"),
    *each(lambda shape: ArrayFrames(np.zeros(shape, np.uint8)), [(3, 5), (4,), (1,) * 5], FramesError, "T, H, W"),
]  # fmt: skip
FORCES: list[Row] = [
    (lambda: force_per_frame([1.0], [0], 1, rule="last"), SettingError, "exposure or mean"),
    *each(lambda index: force_per_frame([1.0, 2.0], index, 3), [[0, 3]], FramesError, "index 3"),
    *each(lambda index: force_per_frame([1.0, 2.0], index, 3), [[-2, 1]], FramesError, "index -2"),
    *each(lambda index: force_per_frame([1.0, 2.0], index, 3), [[0, 0.5]], FramesError, "0.5 in row 1"),
    *each(lambda index: force_per_frame([1.0, 2.0], index, 3), [[0]], FramesError, "2 forces and 1"),
    (lambda: force_per_frame([1.0], [3], 3, where="rig.csv"), FramesError,
     "rig.csv: expected frame indices from -1 to 2, for there are 3 frames"),
    *each(times, [1000 * FRAME_S[INDEX], FRAME_S[INDEX] + 1.7e9, FRAME_S[INDEX] + 0.5, FRAME_S[INDEX] - 2], FramesError,
          r"rig\.csv: expected frame_time_s in seconds, on the clock of time_s"),
    (lambda: times(np.floor(FRAME_S[INDEX])), FramesError,
     "another frame_time_s for each frame, but found 0 s of two frames"),
    (lambda: check_newtons(np.array([1.0, -7000.0]), "log"), FramesError,
     "log: expected forces in N, 200 at most, but found 7000. Which unit is it"),
    (lambda: loading_phase([0.0, 0.3, 0.1]), NoContactError, "0.5 N or more, but found at most 0.3 N"),
    *each(loading_phase, [[], [NAN, NAN]], FramesError, "found none"),
    (lambda: loading_phase([1.0, 2.0, 3.0]), FramesError, "starts in contact"),
    (lambda: loading_phase([0.0, 7.0, 0.0]), FramesError, "within one frame"),
    (lambda: loading_phase([0.0, 1.0, 2.0], stop_n=3.0), FramesError, "at most 2 N"),
    *settings(partial(loading_phase, PRESS), SettingError, start_n=[0.0, NAN], stop_n=[0.5, INF]),
]  # fmt: skip
FLOWS: list[Row] = [
    (lambda: dis_flow(BLANK, BLANK, preset="slow"), SettingError, "slow"),
    (lambda: dis_flow(BLANK, BLANK[1:]), ImageError, "one shape"),
    *settings(FlowSettings, SettingError, engine="lucas-kanade", core_fraction=[0.0, 1.5]),
    (lambda: FlowTracker(FlowSettings(), whole_image=True), SettingError, "dense engine"),
    (lambda: FlowTracker().start(SOME, Region.circle(8, 8, 4)), PinsError, "pins inside it"),
    (lambda: ON_A_DISC.start(SOME, Region.circle(900, 900, 60)), SettingError, "meets the image"),
    (lambda: horn_schunck(np.zeros((8, 9), np.uint8), np.zeros((9, 8), np.uint8)), ImageError, "one shape"),
    (lambda: horn_schunck(np.full((8, 8), NAN), np.zeros((8, 8))), ImageError, "first frame"),
    (lambda: horn_schunck(np.zeros((8, 8)), np.full((8, 8), INF)), ImageError, "second frame"),
    *each(lambda shape: horn_schunck(np.zeros(shape), np.zeros(shape)), [(0, 8), (8,)], ImageError, "first frame"),
    (lambda: HornSchunck().step(np.zeros((8, 8))), ImageError, "no first frame"),
    (lambda: horn_schunck(BLANK, BLANK, roi=(70, 0, 80, 10)), ImageError, "region"),
    *settings(
        HornSchunckSettings, SettingError, alpha=[0.0, NAN], presmoothing_px=-1.0, cell_px=3, sweeps=0, cycles=0,
        warp_above_px=-1.0, pyramid_levels=[0, 17], warps=0, median_px=4, support_px=-1, precision="half",
    ),
    *each(
        lambda pins: fit_affine(pins, pins),
        [PINS[:2], np.full((9, 2), NAN), np.outer(np.arange(9.0), (1.0, 2.0)), np.ones((5, 2)), np.empty((0, 2))],
        PinsError, "3 or more",
    ),
    *each(lambda corners: Region(np.asarray(corners, float)), [
        np.zeros((2, 2)), np.zeros((4, 2)), [[0, 0], [1, 1], [2, 2]], [[0, 0], [1, NAN], [2, 0]],
    ], SettingError, "region"),
    *each(Region.parse, ["150,140", "a,b,c", "1,2,3,4", "150,140,0", "150,140,nan"], SettingError, "region"),
    (lambda: Region.circle(500, 50, 10).box((100, 60)), SettingError, "meets the image"),
    (lambda: Region.circle(0, 0, 5).growth_to(Region.circle(0, 0, 5).advanced(
        Affine(np.array([[-2.0, 0], [0, 0]]), np.zeros(2), np.zeros(2), 3))), PinsError, "inside out"),
]  # fmt: skip
AREAS: list[Row] = [
    (lambda: initial_area(AT_REST, PINS + np.array([5.0, 2.0]), rule="hexagon"), NoContactError, "pins that moved"),
    (lambda: initial_area(AT_REST, moved(63, 1.5), rule="hexagon"), NoContactError,
     r"at most 1\.50 px, by pin 63.*threshold_px"),
    (lambda: initial_area(AT_REST, PINS, rule=AS_PRINTED), AreaError,
     r"as-printed: expected at most .* 44926 px², but found 5\.54\d*e\+06 px²"),
    (lambda: initial_area(AT_REST, PINS, rule=AS_PRINTED, threshold_px=500.0), NoContactError,
     "pairs of pins of the two frames that are more than 500 px apart, but found at most 240 px. Lower threshold_px"),
    (lambda: initial_area(AT_REST, PINS, rule="hexagons"), SettingError, "rule"),
    (lambda: initial_area(AT_REST, PINS, threshold_px=0.0, rule="hexagon"), SettingError, "threshold_px"),
    *each(lambda rule: initial_area(AT_REST, PINS[1:], rule=rule), RULES, PinsError, "127 and 126"),
    *each(lambda rule: initial_area(AT_REST, np.full_like(PINS, NAN), rule=rule), RULES, PinsError, "0 in both"),
]  # fmt: skip
PINS_OF_FRAMES: list[Row] = [
    *each(detect_pins, [STILL[0], np.full((300, 300), 255, np.uint8), np.full((1, 1), 90, np.uint8)],
          PinsError, "uniform"),
    (lambda: detect_pins(np.random.default_rng(0).uniform(0, 1, (300, 300))), PinsError, "not to 1"),
    (lambda: detect_pins(np.kron(np.eye(4), np.full((40, 40), 200.0))), PinsError, "--pitch"),
    (lambda: detect_pins(specks()), PinsError, "too noisy"),
    (lambda: detect_pins(spoilt(NAN)), ImageError, "frame|image"),
    *settings(
        PinSettings, SettingError, block_px=30, contrast=0, min_area_px=0, area_ratio=(1.2, 2), max_aspect=0.5,
        pitch_px=[2.0, INF], expect_pins=2,
    ),
    (lambda: PinTracker().step(SOME), PinsError, "start"),
    (lambda: started(PinTracker(), SOME).step(np.zeros((200, 300), np.uint8)), PinsError, "first frame"),
    (lambda: pins_in_doubt(PINS, 331), PinsError, r"331 pins \(--expect-pins\), but found 127"),
]  # fmt: skip
RATES: list[Row] = [
    (lambda: contact_areas(1.0, [400.0, 400.0]), FramesError, "frame 2.*709"),
    (lambda: contact_areas(1.0, [0.1, np.nan]), FramesError, "step 1"),
    (lambda: contact_areas(1.0, [0.1, 0.1], law="paper"), FramesError, "3 frames"),
    (lambda: contact_areas(-1.0, [0.1]), NoContactError, "initial area"),
    (lambda: contact_areas(1.0, [0.1], law="euler"), SettingError, "ode or paper"),
    *(
        (partial(spread_rate, area, force, rule=rule), FramesError, "expected")
        for rule in RATE_RULES
        for area, force in (
            ([], []), ([1.0], [1.0]), ([1.0, 2.0, 3.0], [NAN] * 3), ([1.0, 2.0], [1.0]),
            ([1.0, NAN, 3.0], [1.0, 2.0, 3.0]), ([1.0, 2.0, 3.0], [1.0, INF, 3.0]),
        )
    ),
    *(
        (partial(spread_rate, np.arange(5.0), force, rule=rule), FramesError, "rising force")
        for rule in ("power", "slope")
        for force in (np.full(5, 3.0), np.linspace(7, 1, 5))
    ),
    (lambda: spread_rate([0.0, 1, 2, 3, 4], [1.0, 2, 3, 4, 5]), FramesError, "1 of 5"),
    *settings(partial(spread_rate, [1.0, 2.0], [1.0, 2.0]), SettingError, rule="median", window_n=(7.0, 0.5)),
]  # fmt: skip
SCORES: list[Row] = [
    *settings(ScoreSettings, SettingError, area_rule=["square", AS_PRINTED], area_law="pde", rate_rule="median",
              threshold_px=0.0, camera_lag_s=[11.0, NAN], specimen_height_mm=[0.0, NAN], quantity="both",
              region="image"),
    (lambda: ScoreSettings(camera_lag_s=0.1, correct_lag=True), SettingError, "camera_lag_s"),
    (lambda: ScoreSettings(region="frame", flow=FlowSettings(engine="dis")), SettingError,
     "region: expected a region, or 'image' with a dense engine"),
    (lambda: score(FrameSequence(ArrayFrames(np.stack([SOME] * 4)))), NoContactError, "3 pins that move more than"),
    (lambda: score(FrameSequence(ArrayFrames(np.stack([SOME] * 4)), None, np.array([0.0, 0.1, 1.0, 2.0]))),
     NoContactError, "first contact"),
    (lambda: score(FrameSequence(ArrayFrames(np.stack([SOME] * 4)), None, np.array([0.0, 0.1, 0.1, 0.2]))),
     NoContactError, "at most 0.2 N"),
    (lambda: score(FrameSequence(ArrayFrames(SOME[None])), ScoreSettings(region=Region.circle(150, 150, 50))),
     FramesError, "two frames"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("call", "error", "said"),
    [*BOARDS, *CAMERAS, *IMAGES, *SEQUENCES, *FORCES, *FLOWS, *AREAS, *PINS_OF_FRAMES, *RATES, *SCORES],
)
def test_it_is_refused_in_these_words(call: Callable[[], object], error: type[CasrError], said: str) -> None:
    with pytest.raises(error, match=said):
        call()
