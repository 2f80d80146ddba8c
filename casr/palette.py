"""The colours of every figure: one place, told apart by people of any colour vision.

Chosen by search: each keeps its hue (blue, purple, green, sky, yellow, red, grey), holds on white paper with a contrast
of 2.2 or more, and lies 19 or more in CIEDE2000 from every other and from ink, as it is and as deuteranopes and
protanopes see it (Machado, Oliveira and Fernandes 2009, IEEE Transactions on Visualization and Computer Graphics 15,
1291, severity 1). Markers and dashes tell as much without colour.
"""

from __future__ import annotations

INK, MUTED, FAINT, GRID = "#1a1a1a", "#555555", "#a0a0a0", "#d9d9d9"
BLUE, PURPLE, GREEN, SKY = "#00346C", "#885BBF", "#65A280", "#82B6CB"
YELLOW, RED, GREY = "#CBAD09", "#872F09", "#645D62"
