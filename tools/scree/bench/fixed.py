"""What exact fixed points cost beside n."""
import math

from .. import block_files
from ..program import Runner
from .processes import ROUNDS
from .tables import growth, print_table


def fixed(given, folder):
    deck, steps, rows = folder / "fixed.ana", 200, []
    deck.write_text(f"1 {steps} 1 1 0.05 0.002\n2500 0 1e9 0.25\n{'0 0 0 ' * 3}\n30 0 0\n"
                    f"&deck dialect='short' /\n&output every={steps} /\n")
    for n in given.blocks:
        blocks = [(1, block_files.box(2 * x, 2 * x + 1, 2 * y, 2 * y + 1)) for x, y in (divmod(i, math.isqrt(n)) for i in range(n))]
        corners = [(*x, i + 1) for i, (_, box) in enumerate(blocks) for x in box]
        times = {}
        for name, points in (("fixed", {"fixed": corners}), ("free", {"measured": corners})):
            run, geometry = Runner(folder, given.scree), (f"{name}.blk", block_files.block_file(name, blocks, **points))
            for _ in range(ROUNDS):
                times[name] = min(times.get(name, math.inf), 1000 * run(deck, geometry, name=name).seconds("steps") / steps)
        rows.append((n, times["fixed"], times["free"]))
    table = zip(rows, growth(rows, lambda row: row[1]), growth(rows, lambda row: row[2]))
    print_table((("blocks", "d"), ("fixed, ms a step", ".2f"), ("growth", ".2f"), ("free", ".2f"), ("growth", ".2f"), ("ratio", ".2f")),
                [(n, held, grows, free, as_free, held / free) for (n, held, free), grows, as_free in table])
