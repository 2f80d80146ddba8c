"""A qbmove of generation 6 and 7, to the byte: the far end of its serial line."""
