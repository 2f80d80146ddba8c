"""The documentation site; ``scripts/docs`` builds it. Every font and script is local."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

from sphinx.application import Sphinx

import emg2vsa

ROOT = Path(__file__).resolve().parent.parent

project = "emg2vsa"
author = "The emg2vsa authors"
copyright = author
version = release = emg2vsa.__version__
language = "en"

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["_build", "style.md"]
nitpicky = True
nitpick_ignore_regex = [("py:.*", ".*")]  # docstrings name types of NumPy and pandas, whose own sites are elsewhere

myst_heading_anchors = 4
myst_enable_extensions: list[str] = []  # no formulas: MathJax would come from another server
nb_execution_mode = "force"
nb_execution_timeout = 120
nb_execution_raise_on_error = True
nb_execution_show_tb = True

autodoc_typehints = "description"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_google_docstring = False

html_theme = "furo"
html_title = "emg2vsa"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
pygments_style = "friendly"
pygments_dark_style = "monokai"

_OUTSIDE = re.compile(r"\[([^\]\n]+)\]\(((?:\.\./)[^)\s#]*)(#[^)\s]*)?\)")


def _offer_files_outside(app: Sphinx, name: str, source: list[str]) -> None:
    """A link to a file of the project that is no page of the site gives the file itself."""
    page = ROOT / "docs" / posixpath.dirname(name)

    def offered(link: re.Match[str]) -> str:
        path = (page / link[2]).resolve()
        if path.is_relative_to(ROOT / "docs") or not path.is_file():
            return link[0]
        return "{download}`" + link[1].replace("`", "") + " <" + link[2] + ">`"

    source[0] = _OUTSIDE.sub(offered, source[0])


def setup(app: Sphinx) -> None:
    app.connect("source-read", _offer_files_outside)
