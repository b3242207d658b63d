"""The words of the manual and of docstrings: sentences that are too long, phrases that are no longer used, pages that are too long,
pictures without a caption, links to nowhere.

Pages are those of doc/ but for doc/notes, README.md and tests/README.md; notes are looked at for their links alone.
"""
import collections
import re

MOST_WORDS = 40            # in a sentence of a page
MOST_WORDS_DOCSTRING = 35  # in a sentence of a docstring
MOST_WORDS_PAGE = 4500
LEAST_WORDS_CAPTION = 3

# Phrases that are refused, as regular expressions, and what to write. doc/glossary.md has the terms.
BANNED = {
    r"what it (?:takes|was|has|comes|came|would|bears|bore)": "the noun",
    r"by few|of few": "the number, or 'some'",
    r"of all energy": "the energy",
    r"anyhow": "'in any position'",
    r"faint(?:ly)?": "'negligible'",
    r"dear(?:er|est)?": "'expensive'",
    r"leaps?": "'jump' or 'cut step'",
    r"wants? an?": "'needs'",
    r"other ways?|in ways": "'other methods' or 'other settings'",
    r"ways? (?:inside|round|through) ": "'path' or 'method'",
    r"(?:a|the|this|whose|largest|least) shares?|shares? of": "'ratio', 'fraction' or 'part'",
    r"paces?": "'step size' or 'speed'",
    r"by as much as|by so much": "the number or the formula",
    r"as (?:is|are) told|is told by": "'is given by'",
    r"those (?:of before|that came before)": "the noun",
    r"holds? against": "'compares with'",
}


def blocks(text):
    """The paragraphs of a page, list items and headings by themselves, as line and words: without code, tables and formulas."""
    fence, start, held = None, 0, []
    for number, line in enumerate([*text.splitlines(), ""], 1):
        mark = re.match(r"\s*(```+|~~~+|\$\$)", line)
        if fence:
            fence = None if mark and line.strip().startswith(fence) else fence
            continue
        opens = mark and not (mark[1] == "$$" and line.strip().count("$$") == 2)
        begins = re.match(r"\s*(?:[-*+]|\d+\.) |#|\||!\[|<|\s*$", line) or mark
        if begins and held:
            yield start, " ".join(held)
            held = []
        if opens:
            fence = mark[1]
        elif re.match(r" {4}", line) and not held or re.match(r"\s*(?:\||!\[|<|\(\S*\)=|\$\$)", line) or not line.strip():
            continue
        else:
            start = start if held else number
            held.append(re.sub(r"^\s*(?:[-*+]|\d+\.|#+) ", "", line).strip())


def plain(words):
    """Words as they are read: code and formulas as one word each, links as their text."""
    words = re.sub(r"`[^`]*`|\$[^$]*\$", " code ", words)
    words = re.sub(r"!?\[([^]]*)\]\([^)]*\)", r"\1", words)
    return re.sub(r"[*_]{1,2}(\S[^*_]*)[*_]{1,2}", r"\1", words)


def sentences(words):
    """The sentences of a paragraph."""
    words = re.sub(r"\b(?:e\.g|i\.e|et al|cf|vs|Eq|Eqs|Fig|Figs|Sect|No|pp?|[A-Z])\.", lambda short: short[0][:-1], plain(words))
    return [part for part in re.split(r"(?<=[.!?])[)\"']?\s+", words) if part.strip()]


def count(sentence):
    return len([word for word in sentence.split() if re.search(r"[A-Za-z]", word)])


def banned(words):
    """The banned phrases in a paragraph, and what to write."""
    for phrase, instead in BANNED.items():
        for found in re.finditer(rf"\b(?:{phrase})\b" if phrase[-1] != " " else rf"\b(?:{phrase})", plain(words), re.I):
            yield found[0].strip(), instead


def of_page(path):
    """What is wrong with the words of a page."""
    text = path.read_text(encoding="utf-8")
    for line, words in blocks(text):
        for sentence in sentences(words):
            if count(sentence) > MOST_WORDS:
                yield path, line, f"prose: expected at most {MOST_WORDS} words in a sentence, found {count(sentence)}: '{sentence[:60]}...'"
        for phrase, instead in banned(words):
            yield path, line, f"prose: expected {instead}, found '{phrase}'"
    words = count(re.sub(r"(?ms)^ {0,3}```.*?^ {0,3}```", "", text))
    if words > MOST_WORDS_PAGE:
        yield path, 1, f"prose: expected at most {MOST_WORDS_PAGE} words on a page, found {words}"
    for number, line in enumerate(text.splitlines(), 1):
        for caption, _ in re.findall(r"!\[([^]]*)\]\(([^)]*)\)", line):
            if count(caption) < LEAST_WORDS_CAPTION:
                yield path, number, f"prose: expected a caption in the brackets of a picture, found '{caption}'"


def anchors(path):
    """The anchors of a page: those that a forge makes of its headings, and labels."""
    text = re.sub(r"(?ms)^ {0,3}```.*?^ {0,3}```", "", path.read_text(encoding="utf-8"))
    found, seen = set(re.findall(r"(?m)^\((\S+)\)=", text)) | set(re.findall(r'(?:id|name)="([^"]+)"', text)), collections.Counter()
    for heading in re.findall(r"(?m)^#+ (.*)$", text):
        heading = re.sub(r"[`*]|\$", "", re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading))
        slug = re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
        found.add(slug if not seen[slug] else f"{slug}-{seen[slug]}")
        seen[slug] += 1
    return found


def broken_links(path):
    """Links of a page to files and anchors that are not there."""
    text = path.read_text(encoding="utf-8")
    text = re.sub(r"(?ms)^ {0,3}```.*?^ {0,3}```", lambda code: "\n" * code[0].count("\n"), text)
    for number, line in enumerate(text.splitlines(), 1):
        for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", line)):
            if re.match(r"[a-z]+:", target):
                continue
            name, _, anchor = target.partition("#")
            file = path.parent / name if name else path
            if not file.exists():
                yield path, number, f"prose: expected a link to a file, found {target}"
            elif anchor and file.suffix == ".md" and anchor not in anchors(file):
                yield path, number, f"prose: expected a link to a heading, found {target}"


def docstrings(path):
    """The paragraphs of docstrings of a Fortran file, as line and words: comments !> and !!, without formulas."""
    start, held = 0, []
    for number, line in enumerate([*path.read_text(encoding="utf-8").splitlines(), ""], 1):
        whole = re.match(r"\s*!>(.*)$", line)
        beside = re.search(r"!!(.*)$", line) if not whole else None
        words = whole[1] if whole else ""
        if held and (not words.strip() or words.startswith("     ")):
            yield start, " ".join(held)
            held = []
        if whole and words.strip() and not words.startswith("     "):
            start = start if held else number
            held.append(words.strip())
        elif beside:
            yield number, beside[1].strip()


def of_docstrings(path):
    """What is wrong with the words of the docstrings of a Fortran file."""
    for line, words in docstrings(path):
        for sentence in sentences(words):
            if count(sentence) > MOST_WORDS_DOCSTRING:
                yield path, line, (f"prose: expected at most {MOST_WORDS_DOCSTRING} words in a sentence of a docstring, "
                                   f"found {count(sentence)}: '{sentence[:60]}...'")
        for phrase, instead in banned(words):
            yield path, line, f"prose: expected {instead}, found '{phrase}'"


def findings(tree):
    """All findings: path, line, text."""
    notes = sorted((tree / "doc" / "notes").glob("*.md"))
    pages = [path for path in sorted((tree / "doc").rglob("*.md")) if path not in notes]
    pages += [tree / "README.md", tree / "tests" / "README.md"]
    for path in pages:
        yield from of_page(path)
    for path in pages + notes:
        yield from broken_links(path)
    for path in sorted((tree / "src").rglob("*.f90")):
        yield from of_docstrings(path)
