"""One HTML file per press, with nothing to load from elsewhere, and an index of many presses."""

from casr.page.pages import Embedded, index_page, press_page

__all__ = ["Embedded", "index_page", "press_page"]
