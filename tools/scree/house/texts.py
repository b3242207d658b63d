"""Constructors of a type that are given a text which a function makes: gfortran 13 writes it beyond its memory."""
import re

from .fortran import statements
from .parts import at_top

CONSTRUCTOR = re.compile(r"(?<![\w%])(\w+_t)\(")
TEXT_FUNCTION = re.compile(r"(trim|adjustl|adjustr|repeat|\w+_text)\(")


def inside(text):
    """What stands before the bracket that closes."""
    depth = 1
    for k, letter in enumerate(text):
        depth += (letter in "([") - (letter in ")]")
        if depth == 0:
            return text[:k]
    return text


def made_in_constructors(paths):
    """Such constructors: path, line, text. The cure is a procedure with a dummy `character(len=*)`, as `append` of `scree_text`."""
    for path in paths:
        for s in statements(path):
            for found in CONSTRUCTOR.finditer(s.text):
                given = at_top(inside(s.text[found.end():]))
                if any(TEXT_FUNCTION.match(part) or "(" in part and len(at_top(part.replace("//", "\n"), "\n")) > 1 for part in given):
                    yield path, s.line, (f"{found[1]} is given a text that a function makes, which gfortran 13 writes beyond its memory: "
                                         "expected an argument or a variable")
