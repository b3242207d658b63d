"""Calls that give a procedure something and a part of it, one of which it may write: a compiler takes two arguments for apart."""
import collections
import re

from .fortran import BEGIN, statements

DECLARATION = re.compile(r"(.+?)::(.*)")
INTENT = re.compile(r"\bintent\s*\(\s*(in|out|in\s*out)\s*\)|\b(value)\b")
CALL = re.compile(r"(?:if\s*\(.*\)\s*)?call\s+([\w%]+(?:\([^()]*\)[\w%]*)*)\s*\((.*)\)$")
GENERIC = re.compile(r"(?:module\s+)?procedure\b(?!\s*\()\s*(?:::)?\s*(.*)")


def at_top(text, separator=","):
    """What separators part outside of brackets."""
    parts, depth, begun = [], 0, 0
    for k, letter in enumerate(text):
        depth += (letter in "([") - (letter in ")]")
        if letter == separator and depth == 0:
            parts.append(text[begun:k].strip())
            begun = k + 1
    return [*parts, text[begun:].strip()]


def intents(paths):
    """From the name of each procedure to its dummies with their intents, for each that has the name; a generic one has those of all
    that it stands for."""
    found, generic = collections.defaultdict(list), collections.defaultdict(set)
    for path in paths:
        around, interface = [], None
        for s in statements(path):
            if match := re.match(r"interface\s+(\w+)$", s.text):
                interface = match[1]
            elif re.match(r"end\s*interface\b", s.text):
                interface = None
            elif interface and (match := GENERIC.match(s.text)):
                generic[interface].update(at_top(match[1]))
            elif begin := BEGIN.match(s.text):
                around.append({name: "unknown" for name in at_top(begin[3] or "") if name})
                found[begin[2]].append(around[-1])
            elif around and re.match(r"end\s*(subroutine|function|program)?\b(?!\s*(if|do|select|associate|where|block|type|interface|"
                                     r"forall|enum))", s.text):
                around.pop()
            elif around and (match := DECLARATION.match(s.text)) and (intent := INTENT.search(match[1])):
                for name in at_top(match[2]):
                    name = re.split(r"[(=\s]", name)[0]
                    if name in around[-1]:
                        around[-1][name] = (intent[1] or intent[2]).replace(" ", "")
    for name, procedures in generic.items():
        for procedure in procedures:
            found[name] += found.get(procedure, [])
    return found


def is_part(whole, part):
    """Whether one designator is a component, an element or a section of another, or the same."""
    if part == whole:
        return True
    return part.startswith((whole + "%", whole + "(")) and len(at_top(re.sub(r"[-+*/<>=.]", ",", part))) == 1


def parts_given(paths):
    """Calls of `paths` with an argument and a part of it that the procedure may write: path, line, text."""
    known = intents(paths)
    found = {}
    for path in paths:
        for s in statements(path):
            if not (call := CALL.match(s.text)):
                continue
            *owner, name = call[1].rsplit("%", 1)
            given = [*owner, *(argument for argument in at_top(call[2]) if argument)]
            for dummies in known.get(name, []):
                found.update(dict.fromkeys(overlapping(path, s.line, name, given, dummies)))
    return list(found)


def overlapping(path, line, name, given, dummies):
    """What is given to the dummies of a procedure, whole and part, of which one may be written."""
    names = list(dummies)
    taken = []
    for position, argument in enumerate(given):
        keyword = re.match(r"(\w+)\s*=(?!=)\s*(.*)", argument)
        dummy = keyword[1] if keyword else names[position] if position < len(names) else None
        if dummy not in dummies:
            return  # another procedure of the name
        taken.append((keyword[2] if keyword else argument, dummies[dummy]))
    for i, (whole, intent) in enumerate(taken):
        for k, (part, of_part) in enumerate(taken):
            if i == k or (part == whole and k < i) or not re.match(r"[a-z_]\w*", whole) or not is_part(whole, part):
                continue
            if "value" not in (intent, of_part) and {intent, of_part} & {"out", "inout"}:
                yield path, line, f"{name} is given {whole} and its part {part}, one of which it may write"
