"""Pages of doc/verification, one a case: its scene, picture, numbers and deck."""
import re
import subprocess
import sys

from ..program import TREE, Runner
from ..results import read

DOC = TREE / "doc"
PAGES, PICTURES = DOC / "verification", DOC / "pictures" / "verification"
LONGEST_DECK = 60  # lines of a deck that its page shows; of a longer one it shows the first of them
LONGEST_ROWS = 4   # lines of bare numbers that follow each other; of more the page shows the first of them


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


def page(name, title, rows, deck, others):
    """The text of the page of a case; `others` is how many decks it runs beside the one that is shown."""
    more = f", and {others} more in its folder" if others else ""
    return f"""# {name}: {title}

    tools/validate {name}

{described(name)}

![{name}: first and last frame](../pictures/verification/{name}.png)

{table(rows)}

Deck: `{deck.relative_to(TREE)}`{more}:

```
{shown(deck.read_text().splitlines())}
```
"""


def write(name, title, rows, made):
    """Writes the page of a case, and draws its last run."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    decks, last = list(dict.fromkeys(deck for deck, _ in made)), read(made[-1][1])
    field = "minor" if len(last.block) > last.n_blocks else "block"
    subprocess.run([sys.executable, "-B", TREE / "tools" / "plot", made[-1][1], "--field", field, "--dpi", "70", "-o",
                    PICTURES / f"{name}.png"], check=True, stdout=subprocess.DEVNULL)
    (PAGES / f"{name}.md").write_text(page(name, title, rows, decks[-1], len(decks) - 1))
