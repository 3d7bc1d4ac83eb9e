"""The documentation site, for Sphinx: pages in Markdown, reference made from the docstrings and the command line."""

import os
import sys
from importlib.metadata import version as installed
from pathlib import Path

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS / "site"))

from site_pages import write_tokens  # noqa: E402

MADE = DOCS / "_made"
write_tokens(MADE / "static")

project = "Maglev FMUs"
release = version = installed("maglev-fmus")
author = "the authors of Maglev FMUs"
project_copyright = author

extensions = ["myst_nb", "sphinx.ext.autodoc", "numpydoc", "site_pages", "reference_pages"]
exclude_patterns = ["_build", "site", "_made/extra", "_made/static"]
nitpicky = False
root_doc = "index"
html_baseurl = os.environ.get("SITE_URL", "")   # of the site, with its last slash: pictures of shared links need it
default_role = "code"           # single backticks in docstrings
highlight_language = "text"     # most blocks are for a shell, or formulas; examples with >>> are known by it

# Equations as MathML, which browsers draw by themselves: the site needs no network.
html_math_renderer = "mathml"
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
ABOUT = "Magnetically levitated stages and their controllers as FMUs: try them, and your controller, in the browser."
myst_html_meta = {"description": ABOUT, "property=og:title": project, "property=og:description": ABOUT,
                  "property=og:image": f"{html_baseurl}_static/live.png"}

nb_execution_mode = "off"   # `make docs` asks for more; the tests run the notebooks' cells by themselves

numpydoc_show_class_members = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"

html_theme = "furo"
html_title = f"Maglev FMUs {release}"
html_favicon = "../maglev/pages/shell/icon.svg"
html_static_path = ["site/static", "_made/static", "live.png"]
html_css_files = ["tokens.css", "site.css"]
html_extra_path = ["_made/extra"] if (MADE / "extra").is_dir() else []   # the live page
html_copy_source = False
html_show_sphinx = False
