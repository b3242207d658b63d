"""Numbers of decks have points, whatever locale a library has set that the system loads with the program."""
import os
import shutil
import subprocess
import sys

import pytest
import scree

# A library that sets the locale of its environment when it is loaded, as toolkits and plug-ins do.
LIBRARY = """#include <locale.h>
#include <stdio.h>
__attribute__((constructor)) static void begin(void) { if (!setlocale(LC_ALL, "de_DE.UTF-8")) fprintf(stderr, "no locale\\n"); }
"""
# Two squares of 1 by 1.5, whose numbers are of few digits, of 17, of 25, and too small for a power of ten that a real holds.
GEOMETRY = """0
8 8 0 0 0 0 0 0
0 -1.5 1 -1.5 1
1 -1.5 1 0 1
1 0 0 0 1
0 0 0 -1.5 1
0 0.00000000000000000000000000050 1 0.00000000000000000000000000050 1
1 0 1.0 1.5000000000000000 1
1 1.500000000000000000000000 0 15.0000000000000001e-1 1
0 1.5 0 0 1
"""


@pytest.fixture(scope="module")
def with_commas(tmp_path_factory):
    """An environment in which C's decimal sign is a comma."""
    folder = tmp_path_factory.mktemp("locale")
    if not (shutil.which("gcc") and shutil.which("localedef")):
        pytest.skip("needs gcc and localedef")
    made = subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", folder / "de_DE.UTF-8"], capture_output=True, check=False)
    asked = subprocess.run([sys.executable, "-c", "import locale; locale.setlocale(locale.LC_ALL, 'de_DE.UTF-8')"],
                           env=os.environ | {"LOCPATH": str(folder)}, capture_output=True, check=False)
    if asked.returncode:
        pytest.skip(f"needs the definition of a locale: {made.stderr}")
    (folder / "sets.c").write_text(LIBRARY)
    subprocess.run(["gcc", "-shared", "-fPIC", folder / "sets.c", "-o", folder / "sets.so"], check=True)
    return {**os.environ, "LOCPATH": str(folder), "LD_PRELOAD": str(folder / "sets.so")}


def test_a_geometry_is_the_same_where_the_locale_has_decimal_commas(with_commas, tmp_path):
    (tmp_path / "a.geo").write_text(GEOMETRY)
    blocks = []
    for env in (dict(os.environ), with_commas):
        done = scree.call("cut", "a.geo", "-o", "a.blk", cwd=tmp_path, env=env)
        assert done.returncode == 0 and "no locale" not in done.stderr, done.stderr
        blocks.append((tmp_path / "a.blk").read_bytes())
        (tmp_path / "a.blk").unlink()
        assert "2 blocks, 0 cracks, area  3.0000000000000000E+00" in done.stdout
    assert blocks[0] == blocks[1]


def test_numbers_of_analysis_groups_and_options_are_the_same_where_the_locale_has_decimal_commas(with_commas, tmp_path):
    (tmp_path / "a.geo").write_text(GEOMETRY)
    (tmp_path / "a.ana").write_text("1 10 1 1 0.05 0.005\n2.5 24.525 1.5e7 0.25\n0.5 0 0  0 0 0  0 0 0\n30.5 0 0\n"
                                    "&deck geometry='a.geo' /\n&support y=0.5 -1.5 1 -1.5 /\n&damping mass=0.125 /\n")
    text = [scree.call("explain", "a.ana", "--set", "integrator.beta=0.75", "--set", "joint(1).c=0.25", cwd=tmp_path, env=env).stdout
            for env in (dict(os.environ), with_commas)]
    assert text[0] == text[1]
    for line in ("(g1): 0.005 ", "(we): 24.525 ", "(phi): 30.5 ", "damping.mass = 0.125 ", "integrator.beta = 0.75 "):
        assert line in text[1], line


def test_a_record_is_the_same_where_the_locale_has_decimal_commas(with_commas, tmp_path):
    (tmp_path / "a.geo").write_text(GEOMETRY)
    (tmp_path / "q.txt").write_text("0.25 0.5 1.25\n7.5d-1 0 0\n")
    (tmp_path / "a.ana").write_text("1 10 1 1 0.05 0.005\n2.5 24.525 1.5e7 0.25\n0 0 0  0 0 0  0 0 0\n30 0 0\n"
                                    "&deck geometry='a.geo' /\n&acceleration file='q.txt', scale=0.5 /\n")
    done = scree.call("explain", "a.ana", cwd=tmp_path, env=with_commas)
    assert "at time 0.25 x y: 0.25 0.625 " in done.stdout and "at time 0.75 x y: 0 0 " in done.stdout
