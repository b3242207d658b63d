"""Notebooks of doc/: cells give the outputs that Jupyter gives, and what differs from the outputs that are kept is found."""
import json
import os
import pathlib
import subprocess
import sys

import pytest
from scree import gallery, notebooks
from scree.errors import ScreeError

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
KEPT = sorted((SOURCE / "doc").glob("*.ipynb"))


def notebook(*cells):
    return {"cells": [{"cell_type": "code", "id": f"c{n}", "metadata": {}, "execution_count": None, "outputs": [], "source": [text]}
                      for n, text in enumerate(cells)], "metadata": {}, "nbformat": 4, "nbformat_minor": 5}


FIGURE = "import matplotlib.pyplot as plt\nplt.figure(figsize=({}, 1)).add_axes((0, 0, 1, 1));"


@pytest.mark.parametrize("path", KEPT, ids=[path.name for path in KEPT])
def test_notebooks_have_been_run_and_their_pictures_are_small(path):
    cells = [cell for cell in notebooks.read_notebook(path)["cells"] if cell["cell_type"] == "code"]
    pictures = [picture for cell in cells for picture in notebooks.pictures_of(cell)]
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    assert pictures and max(map(len, pictures)) < 150e3 and path.name in (SOURCE / "doc" / "index.md").read_text()


@pytest.mark.parametrize("path", KEPT, ids=[path.name for path in KEPT])
def test_notebooks_are_valid(path):
    pytest.importorskip("nbformat", reason="nbformat is not installed, so the schema of notebooks is not checked").validate(notebooks.read_notebook(path))


def test_a_cell_has_what_it_printed_its_value_and_its_figures():
    first, second, third = notebooks.executed(notebook("a = 6\nprint('six')\n7 * a", "a + 1;", FIGURE.format(2)))["cells"]
    assert [one["output_type"] for one in first["outputs"]] == ["stream", "execute_result"] and notebooks.lines_of(first) == ["six", "", "42"]
    assert second["outputs"] == [] and len(notebooks.pictures_of(third)) == 1


def test_a_cell_that_fails_is_named():
    with pytest.raises(ScreeError, match="cell 2: ZeroDivisionError: division by zero"):
        notebooks.executed(notebook("a = 0", "1 / a"))


def test_what_differs_from_the_outputs_that_are_kept_is_found(tmp_path):
    """A number that is off by 0.2 %, a line that is missing, and a picture of another size; a number within 0.05 % is as kept."""
    path = tmp_path / "n.ipynb"
    made = notebooks.executed(notebook("print('a', 100.0)", "print('b', 100.0)", "print('c')", FIGURE.format(2)))
    for cell, source in zip(made["cells"], ("print('a', 100.05)", "print('b', 100.2)", "1;", FIGURE.format(3))):
        cell["source"] = [source]
    path.write_text(json.dumps(made))
    (tmp_path / "run").mkdir()
    rows = gallery.NotebookPage(path).run(tmp_path / "run")
    assert [row.holds for row in rows] == [True, False, False, False]
    assert "b 100.2" in rows[1].wrong and rows[3].wrong.startswith("expected pictures of the sizes")


def test_films_leave_the_figures_of_a_notebook_to_it():
    done = subprocess.run([sys.executable, "-c", "import scree.filming, matplotlib; print(matplotlib.get_backend())"], capture_output=True,
                          text=True, env=os.environ | {"MPLBACKEND": "svg", "PYTHONPATH": str(SOURCE / "tools")})
    assert done.stdout.strip() == "svg", done.stderr
