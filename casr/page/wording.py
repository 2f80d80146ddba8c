"""What a score means, in words a lab person needs no manual for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from casr.spread import readable

if TYPE_CHECKING:
    from casr.score import Score


UNDEFINED = "–"


def number(value: float | None, digits: int = 4) -> str:
    """Significant digits for people; a dash for what is not known."""
    if value is None or value != value:
        return UNDEFINED
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text and abs(value) < 1e7 else text


def verdict(score: Score) -> tuple[str, str, str]:
    """Kind (good, usable or bad), the word for it and what was seen."""
    growth = float(score.area[-1] / score.area[0])
    unit = readable(score.area_unit)
    grew = f"from {number(float(score.area[0]))} to {number(float(score.area[-1]))} {unit} ({growth:.2f} times)"
    if score.doubts:
        return "bad", "Check this press:", f"{'; '.join(score.doubts)}. The contact area went {grew}."
    if score.rate is None:
        return (
            "usable",
            "No spread rate.",
            f"The contact area went {grew}. Without a force log there is no CASR.{_in_pixels(score)}",
        )
    if growth <= 1 or score.rate.value <= 0:
        why = "Is this a loading phase? Were the pins followed? Look at the pictures."
        return "bad", "Check this press.", f"The contact area did not grow with the force: it went {grew}. {why}"
    more = f"The contact area grew {grew}{_force_span(score)}: {_per_newton(score)}{_in_pixels(score)}"
    if score.initial.saturated:
        why = (
            "Nearly every pin had moved at first contact, so the initial area is that of the skin, not of the contact."
        )
        return "bad", "Check this press.", f"{why} {more}"
    if score.notes:
        return "usable", "Scored, with notes.", more
    return "good", "Scored.", more


def headline(score: Score) -> list[tuple[str, str, str]]:
    """Name, value and remark of the numbers that matter."""
    rate, initial = score.rate, score.initial
    facts = []
    if rate is not None:
        interval = f"95 %: {number(rate.low)} to {number(rate.high)}" if rate.low is not None else "no interval"
        facts.append(("CASR", f"{number(rate.value)} {readable(rate.unit)}", interval))
    pins = f"{len(initial.selected)} of {len(score.rest.centroids_px)} pins"
    facts += [
        ("Initial area", f"{number(float(score.area[0]))} {readable(score.area_unit)}", f"{pins}, rule {initial.rule}"),
        ("Growth", f"{score.area[-1] / score.area[0]:.3f} times", f"log growth {score.log_growth.sum():.4f}"),
        ("Frames", f"{len(score.frames)}", f"{score.frames[0]} to {score.frames[-1]}, rest {score.rest_frame}"),
    ]
    return facts


def _in_pixels(score: Score) -> str:
    return (
        ""
        if score.area_unit == "mm2"
        else " No camera file: areas are in px², not mm², and compare with no other camera."
    )


def force_zero(score: Score) -> str:
    """What the force sensor reads at rest, and whether it is in the forces."""
    zero = score.force_zero
    if zero is None:
        return "not determined, nothing taken off"
    done = "taken off" if zero.taken_off else "not taken off"
    return f"{zero.level_n:+.4f} N, standard error {zero.sd_n:.4f} N, from {zero.n} frames at rest; {done}"


def camera_lag(score: Score) -> str:
    """How late the frames are against the force, and what was done about it."""
    lag = score.camera_lag
    if lag is None:
        said = "not determined: the force log has no times"
    elif lag.lag_s is None or lag.sd_s is None:
        said = f"not determined: {lag.why}"
    else:
        said = f"{1e3 * lag.lag_s:+.0f} ms, standard error {1e3 * lag.sd_s:.0f} ms"
    if lag is None or not lag.corrected_s:
        return said
    return f"{said}; {1e3 * lag.corrected_s:+.0f} ms taken off"


def _force_span(score: Score) -> str:
    if score.force_n is None:
        return ""
    return f" while the force rose from {score.force_n[0]:.2f} to {score.force_n[-1]:.2f} N"


def _per_newton(score: Score) -> str:
    rate = score.rate
    if rate is None or rate.rule == "paper":
        return "the CASR here is the paper's sum over frames, comparable only at one frame rate and force range."
    return (
        f"{number(rate.value)} {readable(score.area_unit)} more for each newton. Softer specimens give a larger number."
    )
