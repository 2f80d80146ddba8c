"""One HTML file per press, with nothing to load from elsewhere, and an index of many presses."""

from casr.page.pages import index_page, press_page

__all__ = ["index_page", "press_page"]
