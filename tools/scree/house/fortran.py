"""Reads free-form Fortran as far as the checks of the house need it: statements, the modules used, and procedures.

A counter of its own, because what there is on PyPI miscounts: lizard 1.24.3 does not count `else if`, counts words in strings,
and loses procedures after a word such as `block`; fortitude 0.10.0 adds internal procedures to the one around them.
"""
import dataclasses
import re

QUOTED_OR_COMMENT = re.compile(r"""'(?:[^']|'')*'|"(?:[^"]|"")*"|!.*""")
PREFIX = r"(?:(?:pure|impure|elemental|recursive|module|integer|logical|complex|(?:double\s+precision)" \
         r"|(?:real|complex|type|class|character|integer|logical)\s*\((?:[^()]|\([^()]*\))*\)|real)\s+)*"
BEGIN = re.compile(PREFIX + r"(program|function|subroutine)\s+(\w+)\s*(?:\(([^)]*)\))?")
END = re.compile(r"end\s*(?:(?:program|function|subroutine)\b.*)?$")
BRANCH = re.compile(r"(?:\w+\s*:\s*)?(?:(?:else\s*)?(?:if|where)\s*\(|case\s*\(|(?:type|class)\s+is\s*\(|do\b|forall\b)")
MODULE = re.compile(r"(?:sub)?module\s+(?!procedure\b|function\b|subroutine\b)(?:\(.*\)\s*)?(\w+)$")
USE = re.compile(r"use\b(?:\s*,\s*\w+\s*::|\s*::|\s)\s*(\w+)")


@dataclasses.dataclass
class Statement:
    """A statement, in lower case and with empty strings: where it begins, from 1, and on how many lines it has code."""
    line: int
    text: str
    n_lines: int


@dataclasses.dataclass
class Procedure:
    """A procedure with a body. Own lines have code, and are not those of the procedures that it contains; so is complexity:
    1, and 1 for each branch, case, loop, and each `.and.` and `.or.`."""
    path: object
    module: str
    name: str
    line: int
    arguments: list
    own_lines: int = 0
    complexity: int = 1
    all_lines: int = 0  # with those of the procedures that it contains

    def full_name(self):
        return f"{self.module}.{self.name}"


def statements(path):
    """The statements of a file."""
    found, begun, text, n_lines = [], 0, "", 0
    for number, row in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        code = QUOTED_OR_COMMENT.sub(lambda part: "" if part[0].startswith("!") else "''", row).strip().lower()
        if not code:
            continue
        begun, n_lines = begun or number, n_lines + 1
        text += code.removeprefix("&").removesuffix("&")
        if not code.endswith("&"):
            found.append(Statement(begun, text.strip(), n_lines))
            begun, text, n_lines = 0, "", 0
    return found


def modules_used(path):
    """The line and the name of each `use`."""
    return [(s.line, match[1]) for s in statements(path) if (match := USE.match(s.text))]


def module_of(path):
    """The name of the module that a file holds, or of the file where it holds none."""
    return next((match[1] for s in statements(path) if (match := MODULE.match(s.text))), path.stem)


def procedures(path):
    """The procedures of a file, without those that an interface describes."""
    module, around, found, in_interface = module_of(path), [], [], False
    for s in statements(path):
        if re.match(r"(abstract\s+)?interface\b", s.text):
            in_interface = True
        if in_interface:
            in_interface = not re.match(r"end\s*interface\b", s.text)
            if around:
                around[-1].own_lines += s.n_lines
            continue
        if begin := BEGIN.match(s.text):
            arguments = [name for name in re.split(r"[\s,]+", begin[3] or "") if name]
            around.append(Procedure(path, module, begin[2], s.line, arguments))
            found.append(around[-1])
        if not around:
            continue
        around[-1].own_lines += s.n_lines
        around[-1].complexity += bool(BRANCH.match(s.text)) + len(re.findall(r"\.and\.|\.or\.", s.text))
        if END.match(s.text):
            ended = around.pop()
            ended.all_lines += ended.own_lines
            if around:
                around[-1].all_lines += ended.all_lines
    return found


def names_in(listed):
    """How many names a list has, without its brackets: `a, b => c`."""
    while (inner := re.sub(r"\([^()]*\)|\[[^][]*\]", "", listed)) != listed:
        listed = inner
    return sum(bool(name.strip()) for name in listed.split(","))


def public_names(path):
    """How many names a module lets others use: those of its `public` statements, and what is declared with that attribute."""
    return sum(names_in(match[1]) for s in statements(path)
               if (match := re.match(r"public\s*(?:::|\s)(.*)", s.text) or re.match(r"[^:]*,\s*public\b[^:]*::(.*)", s.text)))


def imported_names(path):
    """How many names a file imports from modules of its own or of others."""
    return sum(names_in(match[1]) for s in statements(path) if (match := re.match(r"use\b.*?,\s*only\s*:(.*)", s.text)))
