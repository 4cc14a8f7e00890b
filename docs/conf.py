"""Sphinx: python -m sphinx -W -b html docs docs/_build."""

import sys
from pathlib import Path

import neurbs

sys.path.insert(0, str(Path(__file__).parent))


project = "neurbs"
author = "The neurbs developers"
copyright = author
version = release = neurbs.__version__

extensions = [
    "myst_parser",
    "numpydoc",
    "settings",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
]
exclude_patterns = ["_build"]
html_static_path = ["static"]
html_css_files = ["settings.css"]
html_theme = "furo"
html_title = f"neurbs {release}"
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#1d5b86", "color-brand-content": "#1d5b86"},
    "dark_css_variables": {"color-brand-primary": "#7db8dd", "color-brand-content": "#7db8dd"},
}

myst_enable_extensions = ["amsmath", "colon_fence", "dollarmath"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc's sections say it in words.
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
default_role = "py:obj"
