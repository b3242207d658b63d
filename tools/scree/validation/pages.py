"""Pages of doc/verification, one a case: its scene, picture, numbers and deck."""
import re
import subprocess
import sys

from ..program import TREE, Runner
from ..results import read

DOC = TREE / "doc"
OVERVIEW, PAGES, PICTURES = DOC / "validation.md", DOC / "verification", DOC / "pictures" / "verification"
LONGEST_DECK = 60  # lines of a deck that its page shows; of a longer one it shows the first of them


class Recorder(Runner):
    """Runs decks, and keeps which they were and where their results are."""

    def __init__(self, *given):
        super().__init__(*given)
        self.made = []  # of the present case: the deck and the name of its results

    def __call__(self, deck, geometry=None, settings=(), name=None):
        results = super().__call__(deck, geometry, settings, name)
        self.made.append((deck, self.folder / f"{name or deck.parent.name + '-' + deck.stem}.h5"))
        return results


def described(name):
    """What doc/validation.md says of a case: scene, answer and tolerance."""
    row = re.search(rf"^\| \[{name}\]\(verification/{name}\.md\) \| (.+) \| (.+) \| (.+) \|$", OVERVIEW.read_text(), re.M)
    return row.groups()


def word(value):
    return value if isinstance(value, str) else f"{value:.7g}"


def table(rows):
    """The numbers of a case as a table."""
    lines = ["| quantity | reference | scree | error | tolerance |", "|---|---|---|---|---|"]
    for row in rows:
        of_number = ("", "") if isinstance(row.reference, str) else (f"{row.error():.1e}", f"{row.tolerance:.1e}")
        lines.append(f"| {' | '.join([row.quantity, word(row.reference), word(row.found), *of_number])} |")
    return "\n".join(lines)


def page(name, title, rows, deck, others):
    """The text of the page of a case; `others` is how many decks it runs beside the one that is shown."""
    scene, answer, _ = described(name)
    lines = deck.read_text().splitlines()
    shown = "\n".join(lines[:LONGEST_DECK] + ["..."] * (len(lines) > LONGEST_DECK))
    place = deck.relative_to(TREE)
    more = f" and {others} more like it in that folder" if others else ""
    return f"""# {name}: {title}

    tools/validate {name}

- **Scene:** {in_page(scene)}
- **Reference:** {in_page(answer)}

![The first frame of a run of {name}, and its last](../pictures/verification/{name}.png)

{table(rows)}

An error is relative to the reference, or to the scale of the quantity where the reference is zero. The deck is `{place}`{more}:

```
{shown}
```
"""


def in_page(text):
    """Links of the overview, from a page in the folder below it."""
    return text.replace("](verification/", "](").replace("](howto/", "](../howto/")


def write(name, title, rows, made):
    """Writes the page of a case, and draws its last run."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    decks, last = list(dict.fromkeys(deck for deck, _ in made)), read(made[-1][1])
    field = "minor" if len(last.block) > last.n_blocks else "block"
    subprocess.run([sys.executable, "-B", TREE / "tools" / "plot", made[-1][1], "--field", field, "--dpi", "70", "-o",
                    PICTURES / f"{name}.png"], check=True, stdout=subprocess.DEVNULL)
    (PAGES / f"{name}.md").write_text(page(name, title, rows, decks[-1], len(decks) - 1))
