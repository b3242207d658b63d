"""Notebooks of doc/: runs their cells in the plain interpreter, and keeps what the cells print, return and draw, as Jupyter does."""
from __future__ import annotations

import ast
import base64
import contextlib
import copy
import io
import json
import pathlib
import struct
import typing

from .errors import ScreeError

Notebook = dict[str, typing.Any]  # the JSON of nbformat 4.5


def read_notebook(path: pathlib.Path) -> Notebook:
    """A notebook as it stands."""
    return json.loads(path.read_text())


def write_executed(source: pathlib.Path, target: pathlib.Path) -> None:
    """Runs a notebook in the present folder, and writes it with its outputs. Where nbformat is installed, the result must be valid."""
    notebook = executed(read_notebook(source))
    with contextlib.suppress(ImportError):
        import nbformat
        nbformat.validate(notebook)
    target.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n")


def executed(notebook: Notebook) -> Notebook:
    """The notebook with the outputs of its cells, which share their names; ScreeError with the number of the cell that fails."""
    notebook, names = copy.deepcopy(notebook), {"__name__": "__main__"}
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    for number, cell in enumerate(cells, 1):
        cell["execution_count"] = number
        try:
            cell["outputs"] = outputs_of("".join(cell["source"]), number, names)
        except Exception as problem:
            raise ScreeError(f"cell {number}: {type(problem).__name__}: {problem}") from problem
    return notebook


def outputs_of(source: str, number: int, names: dict[str, typing.Any]) -> list[dict[str, typing.Any]]:
    """Runs a cell: what it printed, the value of its last expression unless a semicolon ends it, and the figures of pyplot, which close."""
    tree, said, value = ast.parse(source), io.StringIO(), None
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) and not source.rstrip().endswith(";") else None
    with contextlib.redirect_stdout(said):
        exec(compile(tree, f"cell {number}", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), f"cell {number}", "eval"), names)
    outputs: list[dict[str, typing.Any]] = []
    if said.getvalue():
        outputs.append({"output_type": "stream", "name": "stdout", "text": said.getvalue().splitlines(keepends=True)})
    if value is not None:
        outputs.append({"output_type": "execute_result", "execution_count": number, "metadata": {},
                        "data": {"text/plain": repr(value).splitlines(keepends=True)}})
    return outputs + [{"output_type": "display_data", "metadata": {}, "data": {"image/png": picture}} for picture in drawn()]


def drawn() -> list[str]:
    """The open figures of pyplot as pictures in base 64; the figures are closed."""
    import matplotlib.pyplot as plt
    pictures = []
    for figure in map(plt.figure, plt.get_fignums()):
        file = io.BytesIO()
        figure.savefig(file, format="png", bbox_inches="tight")
        pictures.append(base64.b64encode(file.getvalue()).decode())
        plt.close(figure)
    return pictures


def lines_of(cell: dict[str, typing.Any]) -> list[str]:
    """The lines that a cell printed or returned; none of a cell of text."""
    texts = ("".join(one.get("text", one.get("data", {}).get("text/plain", ""))) for one in cell.get("outputs", []))
    return "\n".join(texts).splitlines()


def pictures_of(cell: dict[str, typing.Any]) -> list[bytes]:
    """The pictures that a cell drew, as PNG."""
    return [base64.b64decode(one["data"]["image/png"]) for one in cell.get("outputs", []) if "image/png" in one.get("data", {})]


def size_of(picture: bytes) -> tuple[int, int]:
    """Width and height of a PNG, in dots."""
    width, height = struct.unpack(">II", picture[16:24])
    return width, height
