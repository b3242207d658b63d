"""tools/check, words: long sentences, banned phrases, long pages, pictures without captions, broken links; on pages written for it."""
import os
import pathlib

import pytest
from scree.house import prose

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
LONG = " ".join(["word"] * (prose.MOST_WORDS + 1)) + "."


def said(tmp_path, text):
    page = tmp_path / "page.md"
    page.write_text(text)
    return [(line, words) for _, line, words in [*prose.of_page(page), *prose.broken_links(page)]]


def test_a_long_sentence_is_found_at_its_line(tmp_path):
    (line, words), = said(tmp_path, f"# Title\n\nShort words.\n{LONG}\n")
    assert line == 3 and f"found {prose.MOST_WORDS + 1}" in words


@pytest.mark.parametrize("text", [
    f"```\n{LONG}\n```\n", f"Words:\n\n    {LONG}\n", f"| {LONG} |\n", f"$$\n{LONG}\n$$\n",
    LONG.replace(" word.", ". Word."), f"- {LONG[:100]}\n- {LONG[100:]}\n", "A `" + LONG + "` b.\n"])
def test_code_tables_formulas_and_items_of_lists_are_no_sentences(text, tmp_path):
    assert said(tmp_path, text) == []


@pytest.mark.parametrize("text", ["It falls by a share of it.", "The faint one.", "In other ways it goes.", "A leap."])
def test_a_banned_phrase_is_found(text, tmp_path):
    (line, words), = said(tmp_path, text)
    assert line == 1 and words.startswith("prose: expected ")


def test_a_banned_phrase_in_code_is_none(tmp_path):
    assert said(tmp_path, "The member `share of` has it.\n") == []


def test_a_page_that_is_too_long_is_found(tmp_path):
    assert ["on a page" in words for _, words in said(tmp_path, "A word.\n" * (prose.MOST_WORDS_PAGE // 2 + 1))] == [True]


def test_a_picture_needs_a_caption_and_a_file(tmp_path):
    (tmp_path / "a.png").touch()
    assert said(tmp_path, "![A slope that slides](a.png)\n") == []
    assert ["a caption" in words for _, words in said(tmp_path, "![slope](a.png)\n")] == [True]
    assert ["a link to a file" in words for _, words in said(tmp_path, "![A slope that slides](b.png)\n")] == [True]


def test_links_lead_to_files_and_headings(tmp_path):
    (tmp_path / "other.md").write_text("# One `two` & three\n\n## Twice\n\n## Twice\n\n```\n# No heading\n```\n")
    assert said(tmp_path, "# Here\n\n[a](other.md) [b](other.md#one-two--three) [c](#here) [d](other.md#twice-1) [e](https://x.org)\n") == []
    for link in "none.md", "other.md#four", "#there", "other.md#no-heading":
        (line, words), = said(tmp_path, f"Words.\n\n[a]({link})\n")
        assert line == 3 and link in words


FILE = """!> Short words.
!>
!>     a formula = of many words that is no sentence
module scree_sample
contains
  !> {long}
  pure real function f(x)
    real, intent(in) :: x !! {long}
  end function f
end module scree_sample
"""


def test_long_sentences_of_docstrings_are_found(tmp_path):
    long = " ".join(["word"] * (prose.MOST_WORDS_DOCSTRING + 1))
    (tmp_path / "a.f90").write_text(FILE.format(long=long))
    (tmp_path / "b.f90").write_text(FILE.format(long="Few words."))
    assert [line for _, line, _ in prose.of_docstrings(tmp_path / "a.f90")] == [6, 8]
    assert not list(prose.of_docstrings(tmp_path / "b.f90"))


def test_the_manual_and_the_docstrings_pass():
    assert [f"{path}:{line}: {words}" for path, line, words in prose.findings(SOURCE)] == []
