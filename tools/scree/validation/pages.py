"""Pages of doc/verification, one a case: its scene, picture, numbers and deck."""
import pathlib
import re
import subprocess
import sys
import tempfile

from ..model import Model
from ..program import TREE, Runner
from ..results import read

DOC = TREE / "doc"
PAGES, PICTURES = DOC / "verification", DOC / "pictures" / "verification"
MODELS = TREE / "tools" / "scree" / "validation" / "scenes.py"
LONGEST_DECK = 60  # lines of a deck that its page shows; of a longer one it shows the first of them
LONGEST_ROWS = 4   # lines of bare numbers that follow each other; of more the page shows the first of them


class Recorder(Runner):
    """Runs decks and models, and keeps which they were and where their results are."""

    def __init__(self, *given):
        super().__init__(*given)
        self.made = []  # of the present case: the deck or the model, and the file of its results

    def __call__(self, deck, geometry=None, settings=(), name=None):
        results = super().__call__(deck, geometry, settings, name)
        self.made.append((deck, results.path))
        return results


def described(name):
    """What the page of a case says of its scene and its reference, which is written by hand and kept."""
    path = PAGES / f"{name}.md"
    return re.search(r"(?ms)^- \*\*Scene:.*?(?=\n\n)", path.read_text())[0] if path.exists() else "- **Scene:**\n- **Reference:**"


def word(value):
    return value if isinstance(value, str) else f"{value:.7g}"


def table(rows):
    """The numbers of a case as a table."""
    lines = ["| quantity | reference | scree | error | tolerance |", "|---|---|---|---|---|"]
    for row in rows:
        of_number = ("", "") if isinstance(row.reference, str) else (f"{row.error():.1e}", f"{row.tolerance:.1e}")
        lines.append(f"| {' | '.join([row.quantity, word(row.reference), word(row.found), *of_number])} |")
    return "\n".join(lines)


def shown(lines):
    """The lines of a deck that its page shows, with dots in place of long lists of numbers and of what is beyond the longest deck."""
    kept, rows = [], 0
    for line in lines:
        rows = rows + 1 if re.fullmatch(r"[-+.\deE\s]+/?", line) else 0
        if rows <= LONGEST_ROWS:
            kept.append(line)
        elif rows == LONGEST_ROWS + 1:
            kept.append("...")
    return "\n".join(kept[:LONGEST_DECK] + ["..."] * (len(kept) > LONGEST_DECK))


def deck_of(scene):
    """What a page says of a deck or of a model, and the lines of the deck."""
    if not isinstance(scene, Model):
        return f"Deck: `{scene.relative_to(TREE)}`", scene.read_text().splitlines()
    with tempfile.TemporaryDirectory() as folder:
        lines = scene.save(pathlib.Path(folder, f"{scene.name}.ana")).read_text().splitlines()
    return f"Deck of the model `{scene.name}` of `{MODELS.relative_to(TREE)}`", lines


def page(name, title, rows, scene, others):
    """The text of the page of a case; `others` is how many decks or models it runs beside the one that is shown."""
    said, lines = deck_of(scene)
    more = "" if not others else f", and {others} more" if isinstance(scene, Model) else f", and {others} more in its folder"
    return f"""# {name}: {title}

    tools/validate {name}

{described(name)}

![{name}: first and last frame](../pictures/verification/{name}.png)

{table(rows)}

{said}{more}:

```
{shown(lines)}
```
"""


def write(name, title, rows, made):
    """Writes the page of a case, and draws its last run."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    scenes, last = list(dict.fromkeys(scene for scene, _ in made)), read(made[-1][1])
    decks = [scene for scene in scenes[::-1] if not isinstance(scene, Model)] or scenes
    field = "minor" if len(last.block) > last.n_blocks else "block"
    subprocess.run([sys.executable, "-B", TREE / "tools" / "plot", made[-1][1], "--field", field, "--dpi", "70", "-o",
                    PICTURES / f"{name}.png"], check=True, stdout=subprocess.DEVNULL)
    (PAGES / f"{name}.md").write_text(page(name, title, rows, decks[0], len(decks) - 1))
