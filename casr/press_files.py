"""The files that a scored press is written to where they are asked for: page, pictures and tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from casr.atomic import write_bytes_atomic, write_text_atomic
from casr.errors import SettingError
from casr.frames import FrameSequence
from casr.overlays import Picture, press_pictures
from casr.page import Embedded, index_page, press_page
from casr.press_tables import frames_csv, pins_csv
from casr.scored import Score


@dataclass(frozen=True, kw_only=True)
class PressFiles:
    """Where to write; None: nowhere.

    page : HTML; of several presses an index, with their pages in a folder beside it. figures : folder of SVG pictures;
    of several presses a folder each. pins, frames : CSV, of one press.
    """

    page: Path | None = None
    figures: Path | None = None
    pins: Path | None = None
    frames: Path | None = None

    def check(self, presses: Path, found: Sequence[Path]) -> None:
        """SettingError: tables of more presses than one, or a place among the recordings in ``presses``."""
        tables = {"--pins": self.pins, "--frames": self.frames}
        for option, file in tables.items():
            if file is not None and list(found) != [presses]:
                several = f"{len(found)} presses in {presses}"
                raise SettingError(option, wanted="one press", found=several, do="Score them one by one.")
        if self.pins is not None and self.pins == self.frames:
            raise SettingError("--pins, --frames", wanted="two files", found=str(self.pins), do="Name them apart.")
        raw = presses.resolve()
        for option, file in {**tables, "--page": self.page, "--figures": self.figures}.items():
            if file is not None and raw.is_dir() and raw in (file.resolve(), *file.resolve().parents):
                raise SettingError(
                    option, wanted=f"a place outside {presses}, which holds recordings", found=str(file),
                    do="Raw data stay as they are: choose another folder.",
                )  # fmt: skip

    def of(self, name: str) -> PressFiles:
        """Those of one press of several. Its page is never in a folder that may hold the presses themselves."""
        page, figures = self.page and _pages(self.page) / f"{name}.html", self.figures and self.figures / name
        return PressFiles(page=page, figures=figures)

    def write(self, frames: Callable[[], FrameSequence], score: Score) -> None:
        """All that was asked for of a press; for page and pictures, few of its ``frames`` are decoded once more."""
        if self.page or self.figures:
            sequence = frames()
            pictures = press_pictures(sequence, score)
            if self.figures:
                write_pictures(self.figures, pictures)
            if self.page:
                inside = [Embedded(each.title, each.caption, "image/svg+xml", each.svg()) for each in pictures]
                n_frames, shape = len(sequence), sequence.source.shape
                text = press_page(score, inside, camera=sequence.camera, n_frames=n_frames, shape=shape)
                write_text_atomic(self.page, text)
        if self.pins:
            write_text_atomic(self.pins, pins_csv(score))
        if self.frames:
            write_text_atomic(self.frames, frames_csv(score))

    def write_index(self, title: str, scores: Mapping[str, Score], failures: Mapping[str, str]) -> None:
        """The index of many presses. failures : press to the reason in words."""
        if self.page:
            write_text_atomic(self.page, index_page(title, scores, failures, _pages(self.page).name))


def write_pictures(folder: Path, pictures: Sequence[Picture]) -> None:
    """An SVG of each."""
    for picture in pictures:
        write_bytes_atomic(folder / f"{picture.name}.svg", picture.svg())


def _pages(index: Path) -> Path:
    return index.with_name(f"{index.stem}_pages")
