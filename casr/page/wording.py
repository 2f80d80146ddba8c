"""What a score means, in words a lab person needs no manual for."""

from __future__ import annotations

from casr.scored import Score, Spread
from casr.spread import readable

UNDEFINED = "–"
MEANING = {
    "front": "the contact area, its edge followed in every frame",
    "skin": "the first contact's skin as the flow stretches it: the paper's",
}
"Meaning of the two quantities."


def number(value: float | None, digits: int = 4) -> str:
    """Significant digits for people; a dash for what is not known."""
    if value is None or value != value:
        return UNDEFINED
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text and abs(value) < 1e7 else text


def verdict(score: Score) -> tuple[str, str, str]:
    """Kind (good, usable or bad), the word for it and what was seen."""
    if score.first is None and score.doubts:
        return "bad", "Check this press:", f"{'; '.join(score.doubts)}. Not determined: {not_determined(score)}"
    if score.first is None:
        return "bad", "Not determined:", not_determined(score)
    area = score.area[score.first :]
    growth = float(area[-1] / area[0])
    unit = readable(score.area_unit)
    what = {"front": "contact area", "skin": "skin of the first contact"}[score.settings.quantity]
    grew = f"from {number(float(area[0]))} to {number(float(area[-1]))} {unit} ({growth:.2f} times)"
    if score.doubts:
        return "bad", "Check this press:", f"{'; '.join(score.doubts)}. The {what} went {grew}.{_in_pixels(score)}"
    if score.rate is None:
        more = f"The {what} went {grew}. Without a force log there is no CASR.{_in_pixels(score)}"
        return "usable", "No spread rate.", more
    if growth <= 1 or score.rate.value <= 0:
        why = "Is this a loading phase? Were the pins followed? Look at the pictures."
        return "bad", "Check this press.", f"The {what} did not grow with the force: it went {grew}. {why}"
    more = f"The {what} grew {grew}{_force_span(score)}: {_per_newton(score)}{_in_pixels(score)}"
    if score.settings.quantity == "skin" and score.initial.saturated:
        why = (
            "Nearly every pin had moved at first contact, so the initial area is that of the skin, not of the contact."
        )
        return "bad", "Check this press.", f"{why} {more}"
    if score.notes:
        return "usable", "Scored, with notes.", more
    return "good", "Scored.", more


def not_determined(score: Score) -> str:
    """Why there is no area, and what to do."""
    return (
        f"{score.front_doubt}. Press a larger contact (harder, or on a flatter or softer specimen), see that "
        "camera.toml is there and holds pin_length_mm under [sensor], or take the growth of skin: --quantity skin."
    )


def headline(score: Score) -> list[tuple[str, str, str]]:
    """Name, value and remark of the numbers that matter, the quantity that was asked for first."""
    facts = []
    for spread in (score.chosen, score.other):
        if spread.doubt:
            facts.append((f"CASR ({spread.quantity})", "not determined", ""))
        elif spread.rate is not None:
            value = f"{number(spread.rate.value)} {readable(spread.rate.unit)}"
            facts.append((f"CASR ({spread.quantity})", value, interval(spread)))
        if spread.quantity == score.settings.quantity and score.force_n is not None:
            facts.append(("Forces", mean_over(score), forces_seen(score)))
    if score.front_spread is not None:
        ratio, low, high = score.front_spread.skin_over_front
        facts.append(("Growth, skin over front", f"{ratio:.2f}", f"95 %: {low:.2f} to {high:.2f}"))
    facts += [(f"A_c0 ({name})", value, remark) for name, value, remark in first_areas(score)]
    facts += [(f"Growth ({quantity})", times, "") for quantity, times in growths(score)]
    span = f"{score.frames[0]} to {score.frames[-1]}, rest {score.rest_frame}"
    return [*facts, ("Frames", f"{len(score.frames)}", span)]


def interval(spread: Spread) -> str:
    """The total interval of a rate; where it is not known, what is known, by its name."""
    if spread.interval is not None:
        return f"95 %: {number(spread.interval.low)} to {number(spread.interval.high)}"
    return scatter_only(spread) or "no interval"


def scatter_only(spread: Spread) -> str:
    """The narrow interval of a rate, which holds nothing but the scatter of single areas; empty where there is none."""
    rate = spread.rate
    if rate is None or rate.scatter_low is None:
        return ""
    return f"scatter only, 95 %: {number(rate.scatter_low)} to {number(rate.scatter_high)}"


def mean_over(score: Score) -> str:
    """The forces that the rates are the mean over."""
    window = score.settings.window_n if score.settings.rate_rule == "power" else None
    return f"{window[0]:g} to {window[1]:g} N" if window else "those of the frames"


def forces_seen(score: Score) -> str:
    """The forces of the frames, and from which the front is determined; empty without a force log."""
    if score.force_n is None:
        return ""
    seen = f"frames from {score.force_n[0]:.2f} to {score.force_n[-1]:.2f} N"
    if score.front_spread is None:
        return seen
    return f"{seen}, front determined from {score.front_spread.first_n:.2f} N"


def first_areas(score: Score) -> list[tuple[str, str, str]]:
    """Quantity, its first area and where that is: A_c0 of the front is the area of the first determined frame."""
    unit = readable(score.area_unit)
    found = []
    for spread in (score.chosen, score.other):
        first = spread.first
        if first is None:
            continue
        at = "" if score.force_n is None else f"at {score.force_n[first]:.2f} N, "
        if spread.quantity == "front":
            of = f"{score.front.pins_inside[first]} pins inside, frame {score.frames[first]}"
        else:
            of = f"{len(score.initial.selected)} of {len(score.rest)} pins, rule {score.initial.rule}"
        found.append((spread.quantity, f"{number(float(spread.area[first]))} {unit}", at + of))
    return found


def growths(score: Score) -> list[tuple[str, str]]:
    """Quantity and how many times its area grew, from the first to the last frame that is determined."""
    law = " by equation (1) as printed" if score.settings.area_law == "paper" else ""
    found = []
    for spread in (score.chosen, score.other):
        times = float("nan") if spread.first is None else float(spread.area[-1] / spread.area[spread.first])
        if times == times:
            found.append((spread.quantity, f"{times:.3f} times{law if spread.quantity == 'skin' else ''}"))
    return found


def error_parts(spread: Spread) -> list[tuple[str, str]]:
    """The total interval of a rate and its parts, largest first, as standard errors in per cent."""
    if spread.interval is None:
        return [("total", "not known")]
    parts = sorted(spread.interval.parts.items(), key=lambda part: -part[1])
    shares = [("total", spread.interval.relative_sd), *parts]
    return [(name, f"{100 * share:.1f} %") for name, share in shares]


def left_out(spread: Spread) -> str:
    """What is known to be missing from the total interval."""
    found = spread.interval.left_out if spread.interval else ()
    return "; ".join(found) or "nothing known"


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
        said = "not determined: that takes forces at exposure, from a log with times"
    elif lag.lag_s is None or lag.sd_s is None:
        said = f"not determined: {lag.why}"
    else:
        said = f"{1e3 * lag.lag_s:+.0f} ms, standard error {1e3 * lag.sd_s:.0f} ms"
    if lag is None or not lag.corrected_s:
        return said
    return f"{said}; {1e3 * lag.corrected_s:+.0f} ms taken off"


def _in_pixels(score: Score) -> str:
    said = " No camera file: areas are in px², not mm², and compare with no other camera."
    return "" if score.area_unit == "mm2" else said


def _force_span(score: Score) -> str:
    if score.force_n is None or score.first is None:
        return ""
    return f" while the force rose from {score.force_n[score.first]:.2f} to {score.force_n[-1]:.2f} N"


def _per_newton(score: Score) -> str:
    rate = score.rate
    if rate is None or rate.rule == "paper":
        return "the CASR here is the paper's sum over frames, comparable only at one frame rate and force range."
    unit = readable(score.area_unit)
    return f"{number(rate.value)} {unit} more for each newton. Softer specimens give a larger number."
