"""Delsys Trigno by its SDK server."""
