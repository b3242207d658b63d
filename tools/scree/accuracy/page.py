"""One page of all that a study found, which needs no other file and no network."""
import base64
import html

from ..errors import ScreeError
from .table import columns_of

TITLE = "What accuracy costs in time"
STYLE = """body { font: 14px sans-serif; margin: 2em } table { border-collapse: collapse; font-size: 12px }
td, th { padding: 1px 7px; text-align: right } td.word, th.word { text-align: left } tr:nth-child(even) { background: #f2f2f2 }
tr.default { font-weight: bold } td.front { background: #cfe8cf } img { max-width: 100% }"""


def write_page(path, all_findings, pictures, facts):
    """The page; `pictures` are the files of the diagrams, in the order of the scenes."""
    said = "".join(f"<li>{html.escape(name)}: {html.escape(value)}</li>" for name, value in facts.items())
    body = "".join(section(findings, picture) for findings, picture in zip(all_findings, pictures))
    try:
        path.write_text(f"<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><title>{TITLE}</title>"
                        f"<style>{STYLE}</style></head><body><h1>{TITLE}</h1><ul>{said}</ul>{body}</body></html>\n")
    except OSError as problem:
        raise ScreeError(f"{path}: cannot write: {problem.strerror}") from None


def section(findings, picture):
    """A scene: its diagram, who is cheapest, all its rows."""
    image = base64.b64encode(picture.read_bytes()).decode()
    about = "".join(f"<li>{html.escape(findings.about(name))}</li>" for name in findings.names)
    return (f"<h2>{html.escape(findings.scene.name)}</h2><p>{html.escape(findings.scene.text)}</p><ul>{about}</ul>"
            f"<img alt='work-precision diagram' src='data:image/png;base64,{image}'>{cheapest(findings)}{table(findings)}")


def cheapest(findings):
    """Who reaches an error at the least cost, beside the default."""
    rows = [("quantity", "error", f"the cheapest, by {findings.cost.key}", "of the other strains", "the default")]
    rows += [(name, f"{wanted:g}", *words) for name in findings.names for wanted, *words in findings.cheapest(name)]
    lines = ("".join(f"<td class='word'>{html.escape(text)}</td>" for text in row) for row in rows)
    return (f"<h3>To reach an error, and stay below it with smaller steps</h3>"
            f"<table>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>")


def table(findings):
    columns = [column for column in columns_of(findings.names) if column[0] and any(row.get(column[1]) for row in findings.rows)]
    head = "".join(f"<th{word(width)}>{html.escape(name)}</th>" for name, _, _, width in columns)
    lines = []
    for row in findings.rows:
        cells = "".join(cell(row, *column) for column in columns)
        look = " class=default" if row["default"] else ""
        lines.append(f"<tr{look}>{cells}<td class='word'>{html.escape(ended(row))}</td></tr>")
    said = f"All {len(lines)} runs: the default in bold, green where no other is cheaper, by {findings.cost.key}, and at least as exact"
    return (f"<details><summary>{said}</summary><table><tr>{head}<th></th></tr>{''.join(lines)}</table></details>")


def word(width):
    return " class='word'" if width < 0 else ""


def ended(row):
    return "" if row["ended"] == "complete" else row["ended"]


def cell(row, _, key, form, width):
    text = html.escape(format(row[key], form)) if row.get(key) is not None else "-"
    if key.startswith("error: ") and row.get(key.replace("error", "front", 1)):
        return f"<td class='front'>{text}</td>"
    return f"<td{word(width)}>{text}</td>"
