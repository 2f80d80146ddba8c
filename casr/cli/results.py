"""Scores as people read them on a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from casr.score import Score


def block(score: Score) -> str:
    """One press, a fact per line."""
    settings, frames = score.settings, score.frames
    force = score.force_n
    span = f"{frames[0]} to {frames[-1]}"
    if force is not None:
        span += f", {force[0]:.2f} to {force[-1]:.2f} N"
    pins = f"{len(score.initial.selected)} of {len(score.rest.centroids_px)} pins, rule {score.initial.rule}"
    saturated = ", saturated" if score.initial.saturated else ""
    lines = [
        score.name,
        f"  frames      {len(frames)} ({span}), rest frame {score.rest_frame}",
        f"  A_c0        {score.area[0]:.4g} {score.area_unit} ({pins}{saturated})",
        f"  growth      {score.log_growth.sum():+.4f} in log, {score.area[-1] / score.area[0]:.3f} times the area",
        f"  CASR        {_rate(score)}",
        f"  method      {settings.flow.engine}, area rule {settings.area_rule}, law {settings.area_law}, "
        f"rate {settings.rate_rule}",
    ]
    return "\n".join(lines)


def head(width: int) -> str:
    """Names of the columns of ``row``."""
    names = f"{'frames':>6} {'pins':>5} {'A_c0':>10} {'growth':>7} {'CASR':>9} {'95 % interval':>19} {'notes':>5}  unit"
    return f"{'press':<{width}} {names}"


def row(name: str, score: Score, width: int) -> str:
    """One press of many on a line."""
    rate = score.rate
    interval = f"{rate.low:.4g} to {rate.high:.4g}" if rate and rate.low is not None else "-"
    return (
        f"{name:<{width}} {len(score.frames):>6} {len(score.initial.selected):>5} {score.area[0]:>10.4g} "
        f"{score.log_growth.sum():>7.3f} {f'{rate.value:.4g}' if rate else '-':>9} {interval:>19} "
        f"{len(score.notes):>5}  {rate.unit if rate else score.area_unit}"
    )


def _rate(score: Score) -> str:
    rate = score.rate
    if rate is None:
        return "none: no force belongs to these frames"
    interval = f" ({rate.low:.4g} to {rate.high:.4g}, 95 %)" if rate.low is not None else ""
    window = f", {rate.window_n[0]:g} to {rate.window_n[1]:g} N" if rate.window_n else ""
    return f"{rate.value:.4g} {rate.unit}{interval}{window}, from {rate.n_frames} frames"
