"""Video files."""

from __future__ import annotations

import os
import signal
import struct
import time

import cv2
import numpy as np
import pytest

from casr.decoder_process import DecoderLost, InChild, Limits, child_pid, end_child
from casr.errors import FramesError, PassingError
from casr.frame_files import open_frames, video
from casr.frame_files.video import VideoDecoder


def write_video(path, frames, codec):
    size = frames.shape[2], frames.shape[1]
    video = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter_fourcc(*codec), 20, size, True)
    if not video.isOpened():
        pytest.skip(f"this OpenCV writes no {codec}")
    for frame in frames:
        video.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    video.release()
    return path


def number_of(frame):
    """Frame number from the place of the bright stripe."""
    return int(np.argmax(frame.astype(float).mean(axis=1))) // 8


@pytest.fixture
def striped():
    """(30, 256, 64) frames whose bright stripe tells their number."""
    stack = np.full((30, 256, 64), 20, np.uint8)
    for index, frame in enumerate(stack):
        frame[8 * index : 8 * index + 8] = 220
    return stack


@pytest.mark.parametrize(
    ("name", "codec"), [("press.avi", "FFV1"), ("press.avi", "HFYU"), ("press.avi", "MJPG"), ("press.avi", "XVID"),
                        ("press.mp4", "mp4v"), ("press.mkv", "FFV1"), ("press.mp4", "MPG2"), ("press.avi", "MPG1")]
)  # fmt: skip
def test_frames_in_turn_and_in_any_order(tmp_path, striped, name, codec, monkeypatch):
    # frames that refer to later ones are stored out of turn, where the codec has such frames
    monkeypatch.setenv("OPENCV_FFMPEG_WRITER_OPTIONS", "bf;2")
    sequence = open_frames(write_video(tmp_path / name, striped, codec))
    assert (sequence.name, len(sequence), sequence.shape) == ("press", 30, (256, 64))
    assert [number_of(frame) for frame in sequence] == list(range(30))
    for index in (29, 0, 17, 17, 3, 4, 28):
        assert number_of(sequence[index]) == index
    lossy = any("carry errors" in note for note in sequence.notes)
    assert lossy == (codec not in ("FFV1", "HFYU"))
    if not lossy:
        assert np.abs(sequence[9].astype(int) - striped[9]).max() <= 2


def test_reading_in_turn_never_goes_back(tmp_path, striped, monkeypatch):
    decoder = VideoDecoder(write_video(tmp_path / "press.avi", striped, "MJPG"))
    grabbed = []
    capture = decoder._capture

    class Watched:
        def grab(self):
            grabbed.append(1)
            return capture.grab()

        def __getattr__(self, name):
            return getattr(capture, name)

    monkeypatch.setattr(decoder, "_capture", Watched())
    frames = [frame for first in range(0, 30, 8) for frame in decoder.read_from(first, 8)]
    assert [number_of(frame) for frame in frames] == list(range(30))
    assert len(grabbed) == 29


def test_the_container_s_own_count_is_not_believed(tmp_path, striped):
    path = write_video(tmp_path / "press.avi", striped, "MJPG")
    data = bytearray(path.read_bytes())
    for chunk, place in ((b"avih", 24), (b"strh", 40)):
        at = data.find(chunk) + place
        assert struct.unpack("<I", data[at : at + 4]) == (30,)
        data[at : at + 4] = struct.pack("<I", 500)
    path.write_bytes(data)
    sequence = open_frames(path)
    assert len(sequence) == 30
    assert number_of(sequence[29]) == 29
    assert any("claims 500 frames and holds 30" in note for note in sequence.notes)


def test_a_video_cut_short_gives_the_frames_that_are_whole(tmp_path, striped):
    path = write_video(tmp_path / "press.avi", striped, "MJPG")
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    sequence = open_frames(path)
    assert 5 < len(sequence) < 25
    assert number_of(sequence[len(sequence) - 2]) == len(sequence) - 2
    assert any("claims 30 frames" in note for note in sequence.notes)


def test_a_frame_that_does_not_decode_is_named_and_the_others_keep_their_numbers(tmp_path, striped):
    path = write_video(tmp_path / "press.avi", striped, "MJPG")
    data = bytearray(path.read_bytes())
    at = data.find(b"movi")
    for _ in range(11):
        at = data.find(b"00dc", at + 1)
    (length,) = struct.unpack("<I", data[at + 4 : at + 8])
    data[at + 8 : at + 8 + length] = bytes(length)
    path.write_bytes(data)
    sequence = open_frames(path)
    assert len(sequence) == 30
    with pytest.raises(FramesError, match=r"press.avi, frame 10: expected an image, but found data that do not decode"):
        sequence[10]
    for index in (9, 9, 11, 29, 11):
        assert number_of(sequence[index]) == index


@pytest.mark.parametrize("data", [b"", b"hello, no video"])
def test_what_is_no_video(tmp_path, data):
    (tmp_path / "press.avi").write_bytes(data)
    with pytest.raises(FramesError, match=r"press.avi: expected a video"):
        open_frames(tmp_path / "press.avi")


def test_frames_go_on_after_their_child_was_killed(tmp_path, striped):
    sequence = open_frames(write_video(tmp_path / "press.avi", striped, "MJPG"))
    assert number_of(sequence[3]) == 3
    os.kill(child_pid(), signal.SIGKILL)
    while child_pid() is not None:
        time.sleep(0.01)
    assert [number_of(frame) for frame in sequence] == list(range(30))


def test_a_decoder_that_crashes_is_a_frames_error(tmp_path, striped, monkeypatch):
    (tmp_path / "crashing.py").write_text(
        "import ctypes\nclass Decoder:\n    def read_from(self, first, count):\n        ctypes.string_at(0)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    end_child()
    sequence = open_frames(write_video(tmp_path / "press.avi", striped, "MJPG"))
    monkeypatch.setattr(sequence.source._frames, "_decoder", InChild("OpenCV", "crashing", "Decoder", (), Limits()))
    with pytest.raises(
        FramesError, match=r"press.avi: expected a video .* that its reader crashed \(OpenCV, segm.* Copy"
    ):
        sequence[20]
    end_child()


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no process can be stopped on Windows")
def test_a_video_that_takes_too_long_may_be_sound(tmp_path, striped, monkeypatch):
    path = write_video(tmp_path / "press.avi", striped, "MJPG")
    open_frames(path)  # starts the child
    os.kill(child_pid(), signal.SIGSTOP)
    monkeypatch.setattr(video, "LIMITS", Limits(seconds=0.2))
    with pytest.raises(PassingError, match=r"that its reader took more than .* s\. The file may be sound"):
        open_frames(path)


def test_a_video_whose_decoder_is_killed_twice_may_be_sound(tmp_path, striped, monkeypatch):

    def killed(*_args):
        raise DecoderLost("its reader was killed from outside (OpenCV, killed)")

    frames = open_frames(write_video(tmp_path / "press.avi", striped, "MJPG"))
    monkeypatch.setattr(InChild, "ask", killed)
    with pytest.raises(PassingError, match="killed from outside"):
        frames[5]


def test_a_frame_may_be_changed_without_changing_the_file_s(tmp_path, striped):
    sequence = open_frames(write_video(tmp_path / "press.avi", striped, "MJPG"))
    for frame in sequence:
        frame[:] = 0
    assert number_of(open_frames(tmp_path / "press.avi")[7]) == 7
