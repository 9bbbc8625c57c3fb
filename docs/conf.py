"""Sphinx: `make docs` builds docs/_build/html, with warnings as errors."""

from importlib.metadata import version as installed

project = "esfem-willmore"
author = "the authors of esfem-willmore"
release = version = installed("esfem-willmore")

extensions = ["myst_parser", "numpydoc", "sphinx.ext.autodoc"]
exclude_patterns = ["_build", "walk.md"]  # the walk is part of the architecture
# Formulas are Unicode text, as in docstrings: pages load nothing but the files beside them.
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3

highlight_language = "none"  # what is Python says so
default_role = "code"  # docstrings write `name`
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
numpydoc_show_class_members = False

html_theme = "pydata_sphinx_theme"
html_title = "esfem-willmore"
html_theme_options = {
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": [],
    "footer_end": [],
}
html_static_path = ["_static"]
html_css_files = ["esfem.css"]
html_sidebars = {"**": []}  # few pages: the head of each has them all
html_show_sourcelink = False
html_copy_source = False
