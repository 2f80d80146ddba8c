"""Scores as lines of text: one press with a fact per line, one of many on a line, and a frame of one that goes on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from casr.page import wording

if TYPE_CHECKING:
    from casr.frame_files.growing import NewFrame
    from casr.scored import Score, Spread
    from casr.stream import StreamState


def block(score: Score) -> str:
    """One press, a fact per line."""
    settings, frames, forces = score.settings, score.frames, score.force_n
    span = f"{frames[0]} to {frames[-1]}" + ("" if forces is None else f", {forces[0]:.2f} to {forces[-1]:.2f} N")
    facts = [(f"CASR, {spread.quantity}", _rate(score, spread)) for spread in (score.chosen, score.other)]
    if score.front_spread is not None:
        ratio, low, high = score.front_spread.skin_over_front
        facts.append(("skin/front", f"{ratio:.3f} in growth, 95 %: {low:.3f} to {high:.3f}"))
    facts += [(f"A_c0, {quantity}", f"{area}, {of}") for quantity, area, of in wording.first_areas(score)]
    facts.append(("growth", ", ".join(f"{quantity} {times}" for quantity, times in wording.growths(score))))
    facts.append(("frames", f"{len(frames)} ({span}), rest frame {score.rest_frame}"))
    if forces is not None:
        facts += [("force zero", wording.force_zero(score)), ("camera lag", wording.camera_lag(score))]
    if score.rate is not None:
        parts = ", ".join(f"{name} {share}" for name, share in wording.error_parts(score.chosen))
        facts += [("error", f"standard errors: {parts}"), ("left out", wording.left_out(score.chosen))]
    rules = f"area rule {settings.area_rule}, law {settings.area_law}, rate {settings.rate_rule}"
    facts.append(("method", f"{settings.flow.engine}, {rules}"))
    return "\n".join([
        score.name + (", areas in px², not mm²" if score.area_unit == "px2" else ""),
        *(f"  Check this press: {doubt}" for doubt in score.doubts),
        *([f"  Not determined: {wording.not_determined(score)}"] if score.first is None else []),
        *(f"  {name:<11} {value}" for name, value in facts),
    ])  # fmt: skip


def head(width: int, quantity: str) -> str:
    """Names of the columns of ``row``. width : of the longest name of a press."""
    other = "front" if quantity == "skin" else "skin"
    columns = (f"{quantity} CASR", "95 % interval", "forces, N", "determined", f"{other} CASR", "skin/front")
    return _line("press", width, columns, "frames", "notes", "unit")


def row(name: str, score: Score, width: int) -> str:
    """One press of many on a line."""
    rate, other, total, front, forces = score.rate, score.other, score.interval, score.front_spread, score.force_n
    columns = (
        f"{rate.value:.4g}" if rate else "not determined" if score.first is None else "-",
        f"{total.low:.4g} to {total.high:.4g}" if total else "-",
        "-" if forces is None else f"{forces[0]:.2f} to {forces[-1]:.2f}",
        f"{front.first_n:.2f} N" if front and forces is not None else "-",
        f"{other.rate.value:.4g}" if other.rate else "not determined" if other.doubt else "-",
        f"{front.skin_over_front[0]:.3f}" if front else "-",
    )
    unit = rate.unit if rate else score.area_unit
    check = "  check this press" if score.doubts else ""
    return _line(name, width, columns, len(score.frames), len(score.notes), unit) + check


def frame(new: NewFrame, state: StreamState, spread: Spread | None) -> str:
    """One frame of a press that goes on."""
    parts = [f"frame {new.index:4d}  {state.force_n:6.2f} N  {state.phase:<7}"]
    if state.phase != "rest":
        parts.append("not determined" if state.area is None else f"{state.area:.4g} {state.area_unit}")
    if spread and spread.rate:
        within = f" ({spread.interval.low:.4g} to {spread.interval.high:.4g})" if spread.interval else ""
        parts.append(f"CASR {spread.rate.value:.4g}{within} {spread.rate.unit}")
    return "  ".join((*parts, *state.notes))


def _line(name: str, width: int, columns: tuple[str, ...], frames: object, notes: object, unit: str) -> str:
    wide = " ".join(f"{cell:>{size}}" for cell, size in zip(columns, (14, 18, 13, 10, 14, 10), strict=True))
    return f"{name:<{width}} {wide} {frames!s:>6} {notes!s:>5}  {unit}"


def _rate(score: Score, spread: Spread) -> str:
    if spread.doubt:
        return f"not determined: {spread.doubt}"
    if spread.rate is None:
        return "none: no force belongs to these frames"
    said = f"{spread.rate.value:.4g} {spread.rate.unit}, {wording.interval(spread)}; over {wording.mean_over(score)}"
    return f"{said}, {wording.forces_seen(score)}" if spread.quantity == score.settings.quantity else said
