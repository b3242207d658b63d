"""doc/howto/from-udec.md: a person who knows UDEC finds each of his words, and what the page names of scree is there."""
import os
import pathlib
import re

import pytest
import scree

PAGE = pathlib.Path(os.environ["SCREE_SOURCE"], "doc", "howto", "from-udec.md").read_text()
ROWS = [[cell.strip() for cell in line.strip("|").split("|")] for line in PAGE.splitlines() if line.startswith("| ") and "---" not in line]
WORDS = """arc block boundary cable call cell change config contact crack creep ctol cycle damp delete domain excavate ffield fill find fix
flow fluid fos fraction free gen gravity hide history ini initial insitu jcohesion jcons jdilation jfriction jkn jks jregion jset jtension
large list mark mohr movie mscale new overtol pfix plot pp print prop property quiet reinforce reset restore rockbolt round save seek
small solve split step struct support table thermal title tunnel ubiquitous unbalanced voronoi whilestepping xgrad xvel xvisc ygrad yvisc
zone""".split()


def words_of(cell):
    return {word for code in re.findall(r"`([^`]*)`", cell) for word in re.findall(r"[a-z]+", code)}


@pytest.mark.parametrize("word", WORDS)
def test_the_page_says_what_a_word_is_here(word):
    """In a row whose cell on scree says something."""
    rows = [row for row in ROWS if word in words_of(row[0]) or (word in words_of(row[2]) and word.startswith("j"))]
    assert rows and all(len(row) == 3 and row[1] for row in rows)


def test_settings_that_the_page_names_are_settings():
    known = set(re.findall(r"^\| `(\w+\.\w+)`", scree.call("explain", "--settings").stdout, re.M))
    named = set(re.findall(r"`(\w+\.[a-z]\w+)", " ".join(row[1] for row in ROWS)))
    named = {one for one in named if not one.startswith(("m.", "scree.", "r."))}
    assert len(named) > 10 and named <= known


def test_words_of_models_that_the_page_names_are_words_of_models():
    named = set(re.findall(r"`m\.(\w+)", PAGE))
    assert len(named) > 10 and all(callable(getattr(scree.Model, one)) for one in named)
