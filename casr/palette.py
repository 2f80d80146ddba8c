"""The colours of every figure and page: one place, told apart by people of any colour vision.

Chosen by search: each keeps its hue (blue, purple, green, sky, yellow, red, grey), holds on white paper with a contrast
of 2.2 or more, and lies 19 or more in CIEDE2000 from every other and from ink, as it is and as deuteranopes and
protanopes see it (Machado, Oliveira and Fernandes 2009, IEEE Transactions on Visualization and Computer Graphics 15,
1291, severity 1). Markers and dashes tell as much without colour.
"""

from __future__ import annotations

INK, MUTED, FAINT, GRID = "#1A1A1A", "#555555", "#A0A0A0", "#D9D9D9"
BLUE, PURPLE, GREEN, SKY = "#00346C", "#885BBF", "#65A280", "#82B6CB"
YELLOW, RED, GREY = "#CBAD09", "#872F09", "#645D62"
GOOD, BAD = "#00694D", "#A84300"
"Colours of words: a claim that holds or does not."

ON_PAGES = (
    ("ink", INK, "#E8E8E8"), ("muted", MUTED, "#A8A8A8"), ("line", GRID, "#4A4A4A"), ("page", "#FFFFFF", "#161616"),
    ("blue", BLUE, "#0080FF"), ("purple", PURPLE, "#80517A"), ("green", GREEN, "#90C17E"), ("sky", SKY, "#6ACEFF"),
    ("yellow", YELLOW, "#FDEC07"), ("red", RED, "#A73F1F"), ("grey", GREY, "#A1919B"),
    ("good", GOOD, "#4FD1A5"), ("bad", BAD, "#FF9D5C"), ("soft", "#F4F4F2", "#262626"), ("link", "#00518A", "#8EC7F0"),
)  # fmt: skip
"""Name on a page, colour on white paper, and the colour in its place by night. Those of marks were chosen in the same
way, with a contrast of 2.9 or more on the dark page and 18 or more apart."""
