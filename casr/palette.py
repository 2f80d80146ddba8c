"""The colours of every figure: one place, told apart by people of any colour vision.

Chosen by search: each keeps its hue (blue, purple, green, sky, yellow, red, grey), holds on white paper with a contrast
of 2.2 or more, and lies 19 or more in CIEDE2000 from every other and from ink, as it is and as deuteranopes and
protanopes see it (Machado, Oliveira and Fernandes 2009, IEEE Transactions on Visualization and Computer Graphics 15,
1291, severity 1). Markers and dashes tell as much without colour.
"""

from __future__ import annotations

INK, MUTED, FAINT, GRID = "#1A1A1A", "#555555", "#A0A0A0", "#D9D9D9"
BLUE, PURPLE, GREEN, SKY = "#00346C", "#885BBF", "#65A280", "#82B6CB"
YELLOW, RED, GREY = "#CBAD09", "#872F09", "#645D62"

BY_NIGHT = {
    INK: ("#E8E8E8", "var(--ink)"), MUTED: ("#A8A8A8", "var(--muted)"), GRID: ("#4A4A4A", "var(--line)"),
    BLUE: ("#2C6C9D", "var(--blue)"),
}  # fmt: skip
"""A colour on white paper: the colour in its place on a dark page, and how a drawing in a page asks for either."""
