"""tools/quickstart, as on a machine where everything is installed and built: what it says, in how many lines, and what it leaves."""
import math
import os
import pathlib
import re
import subprocess

import pytest
from scree.program import program

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
STAND_INS = {"cmake": "exit 0", "dpkg-query": "echo installed"}


@pytest.fixture
def checkout(tmp_path):
    """A folder that looks like the sources, with commands that neither build nor install."""
    for name in ("tools", "input"):
        (tmp_path / name).symlink_to(SOURCE / name)
    (tmp_path / "bin").mkdir()
    for name, words in STAND_INS.items():
        command = tmp_path / "bin" / name
        command.write_text(f"#!/bin/sh\n{words}\n")
        command.chmod(0o755)
    return tmp_path


def quickstart(folder, **more):
    return subprocess.run([folder / "tools" / "quickstart"], capture_output=True, text=True, cwd="/",
                          env=os.environ | {"PATH": f"{folder / 'bin'}:{os.environ['PATH']}", "SCREE": str(program(None))} | more)


def test_ten_lines_say_what_it_did_rock_first(checkout):
    """The factor of safety of a block on a plane, tan 40/tan 35, within what the search leaves; each file that is named is there."""
    done = quickstart(checkout)
    assert done.returncode == 0 and not done.stderr, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) <= 10 and all(line.startswith("quickstart: ") and len(line) < 170 for line in lines), done.stdout
    factor = next(line for line in lines if "factor of safety" in line)
    assert float(re.search(r"factor of safety ([\d.]+) ", factor)[1]) == pytest.approx(math.tan(math.radians(40)) / math.tan(math.radians(35)), rel=5e-3)
    named = re.findall(r"results/[\w./-]+\w", done.stdout)
    assert len(named) == 4 and all((checkout / name).stat().st_size > 100 for name in named), named
    assert [name for name in named if name.endswith(".png")] == ["results/slope/slope.png", "results/rotation/t1-and-t4.png"]
    rows = (checkout / "results/rotation/numbers.txt").read_text().splitlines()
    assert len(rows) > 90 and rows[-1] == "every number is met"
    assert "warning" not in done.stdout + "".join(path.read_text() for path in checkout.glob("results/*/*.txt"))


def test_what_fails_is_shown_and_nothing_comes_after(checkout):
    (checkout / "bin" / "cmake").write_text("#!/bin/sh\necho no compiler was found\nexit 1\n")
    done = quickstart(checkout)
    assert done.returncode == 1 and "no compiler was found" in done.stderr and "build/release.log" in done.stderr
    assert "factor of safety" not in done.stdout
