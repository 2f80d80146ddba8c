"""A soft dome with pins: how it is seen, and how its skin moves in contact (finite elements)."""
