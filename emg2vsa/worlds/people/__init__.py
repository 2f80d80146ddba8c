"""People: what their muscles and hands do, on cue or as a page tells them, and what sensors make of it."""
