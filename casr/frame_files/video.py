"""Video files (AVI, MP4, Matroska) through OpenCV in the child process, decoded forward, never by seeking."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.decoder_process import DecoderFailed, DecoderLost, InChild, Limits
from casr.errors import FramesError, PassingError
from casr.frame_files.trouble import OneSize, undecodable, unreadable
from casr.images import Grey, as_grey

# codecs that give back the grey levels they were given
_LOSSLESS = {"FFV1", "HFYU", "FFVH", "PNG", "MPNG", "Y800", "GREY", "DIB", ""}


LIMITS = Limits()
"""Limits of opening a video and of reading each batch of its frames; both grow with the size of the file."""
_BATCH_BYTES = 8_000_000
_MOST_IN_BATCH = 32


class VideoFrames:
    """Frames of a video from the child process; frames read in turn come in batches.

    FramesError : not a video, or OpenCV crashed on it or needed too much memory; on reading, as `VideoDecoder`.
    PassingError : the child was killed from outside, had no room or took too long.
    """

    def __init__(self, path: Path) -> None:
        self.name = path.stem
        self._path = path
        self._first, self._batch = -1, []  # type: int, list[Grey]
        with self._failures():
            self._decoder = InChild("OpenCV", "casr.frame_files.video", "VideoDecoder", (path,), LIMITS.for_file(path))
            self._n: int = self._decoder.ask("__len__")
            self.shape: tuple[int, int] = self._decoder.ask("shape")
            self.notes: tuple[str, ...] = self._decoder.ask("notes")

    def __len__(self) -> int:
        return self._n

    def read(self, index: int) -> Grey:
        following = self._first + len(self._batch)
        if not self._first <= index < following:
            most = min(max(1, _BATCH_BYTES // (self.shape[0] * self.shape[1])), _MOST_IN_BATCH)
            count = most if index == following else 1
            with self._failures():
                self._batch = self._decoder.ask("read_from", index, count)
            self._first = index
        return self._batch[index - self._first]

    @contextmanager
    def _failures(self) -> Iterator[None]:
        try:
            yield
        except DecoderFailed as error:
            wanted, found = "a video that OpenCV can read", f"that {error.reason}"
            if isinstance(error, DecoderLost) or error.limit == "seconds":
                do = "The file may be sound. Free memory, or start fewer processes at a time, then run again."
                raise PassingError(self._path, wanted=wanted, found=found, do=do) from error
            do = "Copy the file again, or save the frames as TIFF or PNG."
            raise FramesError(self._path, wanted=wanted, found=found, do=do) from error


open_file = VideoFrames


class VideoDecoder(OneSize):
    """Frames of a video, decoded one after the other; made in the child process.

    A container's own frame count may be wrong, so the packets are counted, without decoding them. Seeking is exact
    for some codecs only, so a later frame is reached by decoding those between, an earlier one from the start. A
    packet that does not decode shows by its missing time stamp, or where stamps are not kept by the decoder's word:
    reading that frame is an error, and the frames after it keep their numbers.

    FramesError : not a video; on reading, a frame that does not decode or has another size.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        # number of the frame the decoder stands at, and whether it holds it
        self._at, self._grabbed = -1, False
        self._capture = _opened(path)
        claimed, codec = self._capture.get(cv2.CAP_PROP_FRAME_COUNT), self._capture.get(cv2.CAP_PROP_FOURCC)
        times_ms = _packet_times(path)
        self._stamped = self._keeps_stamps(times_ms)
        self._halfway_ms = (times_ms[1:] + times_ms[:-1]) / 2
        if times_ms.size == 0:
            raise undecodable(path, 0, "a video without frames")
        self.notes = _notes(times_ms.size, int(claimed), int(codec))
        super().__init__(path, times_ms.size)

    def read_from(self, first: int, count: int) -> list[Grey]:
        """``count`` frames from ``first`` on; fewer where the video ends or a later one of them is damaged."""
        frames: list[Grey] = []
        for index in range(first, min(first + count, len(self))):
            try:
                frames.append(self.read(index))
            except FramesError:
                if not frames:
                    raise
                break
        return frames

    def _decoded(self, index: int) -> Grey:
        if index < self._at or (index == self._at and not self._grabbed):
            self._rewind()
        for _ in range(index - self._at):
            if self._at < index:
                self._advance()
        decoded, image = self._capture.retrieve() if self._grabbed and self._at == index else (False, None)
        if not decoded or image is None:
            raise undecodable(self._path, index, "data that do not decode")
        return as_grey(image, where=f"{self._path}, frame {index}")

    def _keeps_stamps(self, times_ms: NDArray[np.float64]) -> bool:
        # AVI stores no times, and decoders that reorder frames then shift those that OpenCV counts up
        steps_ms = np.diff(times_ms)
        seen_ms = [self._capture.get(cv2.CAP_PROP_POS_MSEC) for _ in times_ms[:2] if self._capture.grab()]
        self._rewind()
        return bool(
            len(seen_ms) == 2
            and np.all(steps_ms > 0)
            and np.allclose(seen_ms, times_ms[:2], rtol=0, atol=steps_ms[0] / 4)
        )

    def _rewind(self) -> None:
        self._capture = _opened(self._path)
        self._at, self._grabbed = -1, False

    def _advance(self) -> None:
        """Next packet; one that does not decode is passed over."""
        self._grabbed = self._capture.grab()
        if not self._stamped:
            self._at += 1
        elif self._grabbed:
            nearest = np.searchsorted(self._halfway_ms, self._capture.get(cv2.CAP_PROP_POS_MSEC))
            self._at = max(self._at + 1, int(nearest))


def _opened(path: Path) -> cv2.VideoCapture:
    try:
        path.open("rb").close()
    except OSError as error:
        raise unreadable(path, error) from error
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    if not capture.isOpened():
        raise FramesError(
            path, wanted="a video", found="a file that OpenCV cannot open as one",
            do="Check the file, or save the frames as TIFF or PNG.",
        )  # fmt: skip
    return capture


def _packet_times(path: Path) -> NDArray[np.float64]:
    """Time stamps of the packets in the file in the order of the frames, ms, without decoding any."""
    capture = _opened(path)
    capture.set(cv2.CAP_PROP_FORMAT, -1)
    times = []
    while capture.grab():
        times.append(capture.get(cv2.CAP_PROP_POS_MSEC))
    return np.sort(np.array(times, dtype=np.float64))


def _notes(n_frames: int, claimed: int, codec: int) -> tuple[str, ...]:
    name = codec.to_bytes(4, "little").decode("latin-1").strip("\0 ").upper()
    notes = []
    if name not in _LOSSLESS:
        notes.append(f"video compressed with {name}: grey levels carry errors that a lossless file would not")
    if claimed != n_frames:
        notes.append(f"the video claims {claimed} frames and holds {n_frames}: frames may have been lost")
    return tuple(notes)
