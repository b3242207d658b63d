"""How Sphinx builds the manual: the pages of doc/ as they are, in the order in which doc/index.md lists them.

The pages are Markdown that a forge shows as well. So nothing of Sphinx stands in them: the navigation is made of the lists of links
of doc/index.md, and a picture that stands alone in its paragraph becomes a figure with its words as the caption.
"""
import importlib.util
import pathlib
import re
import sys

from docutils import nodes
from sphinx.transforms import SphinxTransform

TREE = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(TREE / "tools"))

project = "scree"
copyright = "the authors of scree"
version = re.search(r"project\(\s*scree\s+VERSION\s+(\S+)", (TREE / "CMakeLists.txt").read_text())[1]
release = version
extensions = ["myst_parser", "sphinx.ext.mathjax"]
exclude_patterns = ["notes", "api.md"]
html_theme = "furo"
html_title = f"scree {version}"
html_copy_source = False
html_show_sourcelink = False
MATHJAX = pathlib.Path(importlib.util.find_spec("sphinx-mathjax-offline").origin).parent / "static" / "mathjax" / "tex-svg.js"
html_static_path = ["static", str(MATHJAX)]
mathjax_path = MATHJAX.name   # beside the pages, so no network is needed
html_css_files = ["scree.css"]
numfig = True
smartquotes = False  # so that the search finds quoted words
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4
myst_links_external_new_tab = False
pygments_style = "friendly"

LINK = re.compile(r"[-|] \[(?P<title>[^]]+)\]\((?P<page>[\w/-]+)\.md\)")
OVERVIEWS = {"validation": "verification", "settings": "settings"}  # pages that list those of a folder
PRINTED = "theory"  # the page, and the folder of pages, that `tools/site --pdf` prints: the root of a build of its own


def navigation(text):
    """Toctrees, one for each heading of the front page that has a list of links below it, hidden on the page."""
    for part in re.split(r"(?m)^## ", text)[1:]:
        links = [f"{found['title']} <{found['page']}>" for found in map(LINK.match, part.splitlines()) if found]
        if links:
            yield "\n".join(["", "```{toctree}", ":hidden:", f":caption: {part.splitlines()[0]}", "", *links, "```", ""])


def add_navigation(app, name, source):
    """The pages that the front page lists, under its headings; those of a folder under the page that lists them."""
    if name == "index":
        source[0] += "".join(navigation(source[0]))
    elif name in OVERVIEWS or name == app.config.root_doc:
        pages = re.findall(rf"\]\(({OVERVIEWS.get(name, PRINTED)}/[\w-]+)\.md[)#]", source[0])
        source[0] += "\n".join(["", "```{toctree}", ":hidden:", "", *dict.fromkeys(pages), "```", ""])


class LonePictures(SphinxTransform):
    """A picture that stands alone in its paragraph is a figure, and its words are the caption."""

    default_priority = 300

    def apply(self, **_):
        for picture in list(self.document.findall(nodes.image)):
            paragraph = picture.parent
            if isinstance(paragraph, nodes.paragraph) and len(paragraph.children) == 1 and picture.get("alt"):
                figure = nodes.figure("", picture, nodes.caption(picture["alt"], picture["alt"]))
                self.document.set_id(figure)   # by which it gets a number
                paragraph.replace_self(figure)


def setup(app):
    app.connect("source-read", add_navigation)
    app.add_transform(LonePictures)
