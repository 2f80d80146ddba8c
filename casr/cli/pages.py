"""Pictures and pages of scored presses, written where they were asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from casr.atomic import write_bytes_atomic, write_text_atomic

if TYPE_CHECKING:
    from casr.frames import FrameSequence
    from casr.overlays import Picture
    from casr.page import Embedded
    from casr.scoring import Score


def write_press(sequence: FrameSequence, score: Score, page: Path | None, figures: Path | None) -> None:
    """The page and the folder of pictures of one press."""
    from casr.overlays import press_pictures
    from casr.page import press_page

    pictures = press_pictures(sequence, score)
    if figures:
        write_pictures(figures, pictures)
    if page:
        text = press_page(
            score, [_embedded(p) for p in pictures], camera=sequence.camera, n_frames=len(sequence),
            shape=sequence.source.shape,
        )  # fmt: skip
        write_text_atomic(page, text)


def pages_folder(index: Path) -> Path:
    """Where the pages of the presses of an index go: beside it, never a folder that may hold the presses themselves."""
    return index.with_name(f"{index.stem}_pages")


def write_index(path: Path, title: str, scores: Mapping[str, Score], failures: Mapping[str, str]) -> None:
    """The index of many presses; their pages are in ``pages_folder``."""
    from casr.page import index_page

    write_text_atomic(path, index_page(title, scores, failures, pages_folder(path).name))


def write_pictures(folder: Path, pictures: Sequence[Picture]) -> None:
    """An SVG of each."""
    for picture in pictures:
        write_bytes_atomic(folder / f"{picture.name}.svg", picture.svg())


def _embedded(picture: Picture) -> Embedded:
    from casr.page import Embedded

    return Embedded(picture.title, picture.caption, "image/svg+xml", picture.svg())
