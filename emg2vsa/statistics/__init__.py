"""Tests, intervals and models as arithmetic: every function takes arrays and gives an outcome."""
