"""Frames: their pace, their size, their loss; the emulated camera, in process and over a network."""

from __future__ import annotations

import threading
import time

import cv2
import numpy as np
import pytest

from casr.frame_files import open_frames
from emg2vsa.devices.clock import VirtualClock, WallClock
from emg2vsa.devices.opencv_camera.driver import FramePace, OpenCvCamera, fitted, lock_settings
from emg2vsa.errors import DeviceError
from emg2vsa.rig.record.press_recorder import PressRecorder
from emg2vsa.worlds.far_ends.camera import CameraServer, EmulatedCamera, FrameTiming
from emg2vsa.worlds.tactile import PressSettings, Scene


@pytest.mark.parametrize(
    ("camera_hz", "kept_hz"), [(20, 20), (19.9, 19.9), (20.1, 20.1), (25, 20), (30, 20), (60, 20), (120, 20), (10, 10)]
)
def test_pace(camera_hz, kept_hz):
    pace = FramePace(20)
    times_s = np.arange(0, 100, 1 / camera_hz)
    missing = [pace.take(time_s) for time_s in times_s]
    kept = [count for count in missing if count is not None]
    assert len(kept) / 100 == pytest.approx(kept_hz, rel=0.02)
    # a camera too slow loses every other frame; no other loses any
    assert sum(kept) == (len(kept) - 1 if camera_hz == 10 else 0)


@pytest.mark.parametrize("lost", [1, 2, 7])
def test_missing_frames_are_counted_in_spite_of_jitter(lost):
    pace = FramePace(20)
    rng = np.random.default_rng(lost)
    numbers = [number for number in range(100) if not 50 <= number < 50 + lost]
    missing = [pace.take(number / 20 + rng.uniform(0, 0.004)) for number in numbers]
    assert [count for count in missing if count] == [lost]
    assert None not in missing


def test_frames_are_cut_to_the_centre_and_shrunk():
    image = np.zeros((480, 640, 3), np.uint8)
    image[:, 80:560] = 100
    image[:, :80] = image[:, 560:] = 255
    small = fitted(image, (300, 300))
    assert small.shape == (300, 300)
    assert small.dtype == np.uint8
    assert (small == 100).all()
    exact = np.arange(90_000, dtype=np.uint32).astype(np.uint8).reshape(300, 300)
    np.testing.assert_array_equal(fitted(exact, (300, 300)), exact)


class HandClock:
    """Time that a test sets; whoever sleeps lets the others work."""

    time_s = 0.0

    def now_s(self):
        return self.time_s

    def sleep_until(self, time_s):
        time.sleep(1e-4)


class Capture:
    """A capture that gives as many frames as a test allows, then waits for more or fails."""

    def __init__(self, opens=True):
        self.opens = opens
        self.allowed = threading.Semaphore(0)
        self.taken = threading.Semaphore(0)
        self.has = {}
        self.set_to, self.fails, self.count, self.released = {}, False, 0, threading.Event()

    def isOpened(self):
        return self.opens

    def set(self, key, value):
        self.set_to[key] = value
        if key in self.has:
            self.has[key] = value
        return key in self.has

    def get(self, key):
        return self.has.get(key, 0.0)

    def grab(self):
        self.taken.release()
        self.allowed.acquire(timeout=60)
        return not self.fails

    def retrieve(self):
        self.count += 1
        return True, np.full((300, 300, 3), self.count, np.uint8)

    def release(self):
        self.released.set()

    def give(self, fails=False):
        """Let a frame come, and return when it was taken and the camera waits for the next."""
        self.taken.acquire(timeout=60)
        self.fails = fails
        self.allowed.release()
        if not fails:
            self.taken.acquire(timeout=60)
            self.taken.release()


@pytest.fixture
def clock():
    return VirtualClock()


@pytest.fixture
def hand():
    return HandClock()


@pytest.fixture
def capture():
    return Capture()


@pytest.fixture
def camera(hand, capture):
    capture.allowed.release()
    camera = OpenCvCamera(3, hand, open_capture=lambda source: capture)
    camera.start()
    capture.taken.acquire(timeout=60)
    yield camera
    camera._ended.set()
    capture.fails = True
    capture.allowed.release()
    camera.close()
    assert capture.released.wait(60)


def test_frames_come_with_their_times(hand, capture, camera):
    start_s = camera.frames()[0].time_s
    for number in (1, 2, 5):
        hand.time_s = start_s + number / 20
        capture.give()
    frames = camera.frames()
    assert [frame.dropped for frame in frames] == [0, 0, 2]
    np.testing.assert_allclose([frame.time_s - start_s for frame in frames], [0.05, 0.1, 0.25])
    assert [int(frame.image[0, 0]) for frame in frames] == [2, 3, 4]
    assert camera.dropped == 2
    assert camera.frames() == []
    assert capture.set_to[cv2.CAP_PROP_FPS] == 20


def test_a_frame_is_timed_when_it_was_exposed(hand, capture):
    capture.allowed.release()
    camera = OpenCvCamera(3, hand, delay_s=0.06, open_capture=lambda source: capture)
    camera.start()
    capture.taken.acquire(timeout=60)
    assert camera.frames()[0].time_s == pytest.approx(hand.now_s() - 0.06)
    hand.time_s = 0.45  # lost is one that brings nothing, not one whose frames are old
    assert camera.frames() == []
    capture.give(fails=True)
    assert capture.released.wait(60)


def test_a_camera_that_falls_silent(hand, camera):
    camera.frames()
    hand.time_s = 0.4
    assert camera.frames() == []
    hand.time_s = 0.6
    with pytest.raises(DeviceError, match=r"camera 3.*no frame for 0\.6 s"):
        camera.frames()


def test_a_camera_that_is_pulled_out(capture, camera):
    camera.frames()
    capture.give(fails=True)
    assert capture.released.wait(60)
    camera._thread.join(5)
    with pytest.raises(DeviceError, match="no frame"):
        camera.frames()


def test_cameras_that_do_not_open(clock):
    with pytest.raises(DeviceError, match="none that opens"):
        OpenCvCamera(9, clock, open_capture=lambda source: Capture(opens=False)).start()
    with pytest.raises(DeviceError, match="not started"):
        OpenCvCamera(9, clock).frames()


def test_a_film_is_a_camera_until_it_ends(tmp_path):
    film = cv2.VideoWriter(str(tmp_path / "film.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 20, (300, 300))
    for level in (50, 100):
        film.write(np.full((300, 300, 3), level, np.uint8))
    film.release()
    camera = OpenCvCamera(str(tmp_path / "film.avi"), WallClock())
    camera.start()
    camera._thread.join(5)
    assert int(camera.frames()[0].image[0, 0]) == pytest.approx(50, abs=2)
    with pytest.raises(DeviceError, match="no frame"):
        camera.frames()
    camera.close()


@pytest.fixture
def scene():
    return Scene(PressSettings())


def test_the_emulated_camera_sees_the_force_of_its_time(clock, scene):
    camera = EmulatedCamera(scene, lambda time_s: 10 * time_s, clock)
    camera.start()
    clock.sleep_until(0.12)
    frames = camera.frames()
    assert [frame.time_s for frame in frames] == [0, 0.05, 0.1]
    for index, frame in enumerate(frames):
        np.testing.assert_array_equal(frame.image, scene.image(index / 2, index))
    assert camera.frames() == []


def test_frames_arrive_late_and_bear_their_arrival_less_the_mean_latency(clock, scene):
    asked_s = []
    timing = FrameTiming(0.035, jitter_s=0.005, late_share=0.02, late_s=0.03, seed=3)
    camera = EmulatedCamera(scene, lambda time_s: asked_s.append(time_s) or 0.0, clock, timing=timing)
    camera.latency_s = 0.038  # of this press; nobody tells the rig
    camera.start()
    stamps_s = []
    for tick in range(1, 20_000):
        clock.sleep_until(tick / 200)
        for frame in camera.frames():
            assert clock.now_s() - 0.005 <= frame.time_s + 0.035 <= clock.now_s() + 1e-9
            stamps_s.append(frame.time_s)
    # what is seen is that of the exposure
    np.testing.assert_allclose(asked_s, np.arange(len(asked_s)) / 20, atol=1e-9)
    late_s = np.array(stamps_s) - asked_s
    usual = late_s[late_s < 0.02]
    assert np.mean(usual) == pytest.approx(0.003, abs=0.0005)
    assert np.std(usual) == pytest.approx(0.005, rel=0.06)
    assert np.mean(late_s > 0.02) == pytest.approx(0.02, abs=0.008)
    assert np.all(np.diff(stamps_s) >= 0)


def test_emulated_faults(clock, scene):
    camera = EmulatedCamera(scene, lambda time_s: 0.0, clock)
    camera.start()
    camera.frames()
    camera.faults.drop = 2
    clock.sleep_until(0.16)
    assert [frame.dropped for frame in camera.frames()] == [2]
    assert camera.dropped == 2
    camera.faults.mute = True
    clock.sleep_until(0.64)
    assert camera.frames() == []
    clock.sleep_until(0.85)
    with pytest.raises(DeviceError, match=r"no frame for 0\.7 s"):
        camera.frames()


def test_a_press_seen_recorded_and_read(tmp_path, clock, scene):
    camera = EmulatedCamera(scene, lambda time_s: 5 * time_s, clock)
    camera.start()
    recorder = PressRecorder(tmp_path / "press", camera.shape)
    for tick in range(100):
        clock.sleep_until(tick / 200)
        for frame in camera.frames():
            recorder.frame(frame.image, frame.time_s)
        recorder.force(clock.now_s(), 5 * clock.now_s())
    recorder.close()
    press = open_frames(tmp_path / "press")
    assert len(press) == 10
    np.testing.assert_allclose(press.force_n, 0.25 * np.arange(10), atol=1e-6)
    np.testing.assert_array_equal(press[7], scene.image(1.75, 7))


def test_the_emulated_camera_over_a_network(scene):
    clock = WallClock()
    emulated = EmulatedCamera(scene, lambda time_s: 1.0, clock)
    with CameraServer(emulated) as server:
        camera = OpenCvCamera(server.url, clock)
        camera.start()
        first = camera.frames()[0]
        camera.close()
    difference = first.image.astype(int) - scene.image(1.0, 0)
    assert np.abs(difference).max() <= 12
    assert np.abs(difference).mean() < 1


def test_no_camera_at_another_address(scene):
    clock = WallClock()
    with CameraServer(EmulatedCamera(scene, lambda time_s: 1.0, clock)) as server:
        camera = OpenCvCamera(server.url.replace("frames", "other"), clock)
        with pytest.raises(DeviceError, match="none that opens"):
            camera.start()


def webcam(**changes):
    """Capture whose exposure, gain and white balance can be set; it has chosen 90, 4 and 4600 K."""
    capture = Capture()
    capture.has = {
        cv2.CAP_PROP_AUTO_EXPOSURE: 3.0, cv2.CAP_PROP_AUTO_WB: 1.0, cv2.CAP_PROP_BACKEND: cv2.CAP_V4L2,
        cv2.CAP_PROP_EXPOSURE: 90.0, cv2.CAP_PROP_GAIN: 4.0, cv2.CAP_PROP_WB_TEMPERATURE: 4600.0,
    } | changes  # fmt: skip
    return capture


KEEP = {"exposure": None, "gain": None, "white_balance_k": None}


def test_what_the_camera_has_chosen_stays_and_what_the_rig_file_says_is_set():
    capture = webcam()
    assert lock_settings(capture, KEEP, "camera") == {"exposure": 90.0, "gain": 4.0, "white_balance_k": 4600.0}
    assert lock_settings(webcam(), KEEP | {"exposure": 156.0}, "camera")["exposure"] == 156.0
    assert lock_settings(Capture(), KEEP, "camera") == KEEP  # a network camera knows none of it
    assert (capture.has[cv2.CAP_PROP_AUTO_EXPOSURE], capture.has[cv2.CAP_PROP_AUTO_WB]) == (1.0, 0.0)


@pytest.mark.parametrize("key", KEEP)
def test_a_value_that_is_not_taken_is_told(key):
    told = f"camera, {key}: expected 7, as the rig file says, but found a camera that does"
    with pytest.raises(DeviceError, match=told):
        lock_settings(Capture(), KEEP | {key: 7.0}, "camera")
