"""The tests that a referee asks for beside those of the paper."""
