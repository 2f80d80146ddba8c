"""The presses of a folder, each scored beside the others, and the files they are written to where asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from casr import overlays, page
from casr.atomic import write_bytes_atomic, write_text_atomic
from casr.doubts import stretch_of, unlike_others
from casr.errors import CasrError, PassingError, SettingError
from casr.frames import FrameSequence
from casr.press_tables import frames_csv, pins_csv
from casr.scored import Score, ScoreSettings
from casr.scoring import score

if TYPE_CHECKING:
    from casr.svg import Picture


@dataclass(frozen=True)
class FolderScores:
    """Presses by name. scores : of those that could be scored; not_scored : why of the others; unlike : what sets a
    press apart from the others, which is a doubt of its score, too."""

    scores: Mapping[str, Score]
    not_scored: Mapping[str, str]
    unlike: Mapping[str, str]


def named_presses(root: Path, found: Sequence[Path]) -> dict[str, Path]:
    """The presses by their path below ``root`` with dashes, without a file's suffix."""
    bare = {path: path.with_suffix("") if path.is_file() else path for path in found}
    return {"-".join(name.relative_to(root).parts): path for path, name in bare.items()}


def score_presses(
    presses: Mapping[str, Path],
    settings: ScoreSettings,
    open_press: Callable[[Path], FrameSequence],
    told: Callable[[str, Score | CasrError | PassingError], None],
) -> FolderScores:
    """Score one press after the other; ``told`` hears of each, by itself, as soon as it is done."""
    scores: dict[str, Score] = {}
    not_scored: dict[str, str] = {}
    for name, path in presses.items():
        try:
            scores[name] = score(open_press(path), settings)
        except (CasrError, PassingError) as error:
            not_scored[name] = str(error)
            told(name, error)
        else:
            told(name, scores[name])
    stretches = {name: stretch_of(scored) for name, scored in scores.items()}
    unlike = unlike_others({name: stretch for name, stretch in stretches.items() if stretch is not None})
    for name, reason in unlike.items():
        scores[name] = replace(scores[name], doubts=(*scores[name].doubts, reason))
    return FolderScores(scores, not_scored, unlike)


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
            pictures = overlays.press_pictures(sequence, score)
            if self.figures:
                write_pictures(self.figures, pictures)
            if self.page:
                n_frames, shape = len(sequence), sequence.source.shape
                text = page.press_page(score, pictures, camera=sequence.camera, n_frames=n_frames, shape=shape)
                write_text_atomic(self.page, text)
        if self.pins:
            write_text_atomic(self.pins, pins_csv(score))
        if self.frames:
            write_text_atomic(self.frames, frames_csv(score))

    def write_index(self, title: str, scores: Mapping[str, Score], failures: Mapping[str, str]) -> None:
        """The index of many presses. failures : press to the reason in words."""
        if self.page:
            write_text_atomic(self.page, page.index_page(title, scores, failures, _pages(self.page).name))


def write_pictures(folder: Path, pictures: Sequence[Picture]) -> None:
    """An SVG of each."""
    for picture in pictures:
        write_bytes_atomic(folder / f"{picture.name}.svg", picture.file())


def _pages(index: Path) -> Path:
    return index.with_name(f"{index.stem}_pages")
