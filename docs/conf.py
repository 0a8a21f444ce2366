"""Configuration of the documentation's site: ``make docs`` builds it, without a network."""

from importlib import metadata

from docutils import nodes


project = "pathgene"
author = "The pathgene authors"
release = metadata.version("pathgene")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]

myst_heading_anchors = 4

napoleon_google_docstring = False
napoleon_use_rtype = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
autodoc_class_signature = "mixed"
python_maximum_signature_line_length = 88

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_title = "pathgene"
html_show_copyright = False
html_copy_source = False
html_show_sourcelink = False


def setup(app):
    """Make every drawing a link to its full size, as Sphinx does with scaled images."""
    app.connect("doctree-read", _scale_drawings)


def _scale_drawings(app, doctree):
    for image in doctree.findall(nodes.image):
        if image["uri"].endswith(".svg"):
            image["width"] = "100%"
