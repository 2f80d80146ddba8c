"""One HTML file per press, with nothing to load from elsewhere, and an index of many presses."""

from typing import TYPE_CHECKING

from casr.lazy_names import lazy_names

if TYPE_CHECKING:
    from casr.page.pages import index_page, press_page

__all__ = ["index_page", "press_page"]

__getattr__, __dir__ = lazy_names(__name__, dict.fromkeys(__all__, "pages"))
