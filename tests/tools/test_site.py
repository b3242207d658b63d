"""tools/site: the manual builds without a warning, every page is in its navigation, and nothing on it needs a network."""
import os
import pathlib
import re
import shutil
import subprocess

import pytest

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
PYTHON = SOURCE / "build" / "site" / "python" / "bin" / "python"
CONFIGURATION = SOURCE / "tools" / "scree" / "house" / "site"
NOT_BUILT = {"api"}  # the front page of the pages of FORD

pytestmark = pytest.mark.skipif(not PYTHON.exists(), reason="Sphinx is not installed: run tools/site once")


def build(pages, folder):
    return subprocess.run([PYTHON, "-B", "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-c", CONFIGURATION, "-d",
                           folder / "trees", pages, folder / "html"], capture_output=True, text=True)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    done = build(SOURCE / "doc", folder)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return folder / "html"


def pages():
    """The pages of the manual, as paths below doc/ without their ending."""
    names = {path.relative_to(SOURCE / "doc").with_suffix("").as_posix() for path in (SOURCE / "doc").rglob("*.md")}
    return {name for name in names if not name.startswith("notes/")} - NOT_BUILT


def test_every_page_is_in_the_navigation_of_the_first(site):
    tree = re.search(r'(?s)<div class="sidebar-tree">(.*?)</div>\s*</div>', (site / "index.html").read_text())[1]
    assert {link for link in re.findall(r'href="([\w/-]+)\.html"', tree)} == pages() - {"index"}


def test_every_page_can_be_found_by_the_search(site):
    index = (site / "searchindex.js").read_text()
    listed = set(re.search(r'"docnames": ?\[(.*?)\]', index)[1].replace('"', "").replace(" ", "").split(","))
    assert listed == pages()


def test_nothing_is_loaded_from_a_network(site):
    for page in site.rglob("*.html"):
        loaded = re.findall(r'<(?:script|img|iframe)[^>]* src="([^"]+)"|<link[^>]* rel="stylesheet"[^>]* href="([^"]+)"', page.read_text())
        assert not [a or b for a, b in loaded if re.match(r"(?:https?:)?//", a or b)], page


def test_a_link_to_nowhere_fails_the_build(tmp_path):
    shutil.copytree(SOURCE / "doc", tmp_path / "doc")
    with open(tmp_path / "doc" / "tutorial.md", "a") as page:
        page.write("\nSee [nothing](no-such-page.md).\n")
    done = build(tmp_path / "doc", tmp_path)
    assert done.returncode != 0 and "no-such-page.md" in done.stderr
