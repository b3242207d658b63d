"""The two orders of an analysis deck: which one is read, and where a deck with a wrong count of numbers is wrong."""
import os
import pathlib
import re

import pytest
import scree

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
FREE = "0.001\n4 4 0 0 0 0 0 0\n0 0 1 0 1\n1 0 1 1 1\n1 1 0 1 1\n0 1 0 0 1\n"  # without fixed and load points
HELD = FREE.replace("4 4 0 0 0 0 0 0", "4 4 0 0 1 1 0 0") + "0 0 0 0\n0.5 0.5\n"
GROUP = "&support y=0 0 1 0 /\n"
HEAD = ["1 10 2 2 0.05 0.01"]
TABLES = ["0", "2 2", "0 0 0  1 0.5 0", "0 0 0  1 3.5 0"]
MATERIALS = ["2500 26.487 1.5e10 0.25", "0.5 0.5 0", "0 0 0", "0 0 0.25", "2600 26.5 1.5e10 0.25", "0 0 0 0 0 0 0 0 0", "30.5 0 0", "35 1.5 0"]
NAMES = ["ma we E nu of block material 1", "s11 s22 s12 of block material 1", "t11 t22 t12 of block material 1",
         "vx vy vr of block material 1", "ma we E nu of block material 2", "s11 s22 s12 of block material 2",
         "phi c T of joint material 1", "phi c T of joint material 2"]


def check(folder, lines, groups="", geometry=FREE, *options):
    (folder / "a.geo").write_text(geometry)
    (folder / "a.ana").write_text("\n".join([*lines, groups]))
    return scree.call("check", "a.geo", "a.ana", *options, cwd=folder)


def refused(folder, lines, groups="", geometry=FREE):
    done = check(folder, lines, groups, geometry)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stdout + done.stderr
    return done.stderr


@pytest.mark.parametrize("groups", ["", GROUP, "&deck dialect='short' /\n"])
@pytest.mark.parametrize("row", range(len(MATERIALS)))
def test_a_decimal_comma_is_told_with_its_row_where_shis_order_has_as_many_numbers(row, groups, tmp_path):
    for word in re.findall(r"\d+\.\d+", MATERIALS[row]):
        lines = HEAD + MATERIALS
        lines[1 + row] = lines[1 + row].replace(word, word.replace(".", ","), 1)
        said = refused(tmp_path, lines, groups)
        assert f"a.ana:{2 + row}: expected {len(MATERIALS[row].split())} numbers" in said, said
        assert NAMES[row].split(" of ")[1] in said and "the decimal sign is a point" in said, said


@pytest.mark.parametrize("groups", ["", GROUP, "&deck dialect='short' /\n"])
@pytest.mark.parametrize("row", range(len(MATERIALS)))
def test_a_missing_number_is_told_with_its_row(row, groups, tmp_path):
    words = MATERIALS[row].split()
    for left in (words[:-1], words[1:]):
        lines = HEAD + MATERIALS
        lines[1 + row] = " ".join(left)
        said = refused(tmp_path, lines, groups)
        names, thing = NAMES[row].split(" of ")
        if len(words) == 9:
            names = "vx vy vr"
        number = len(names.split())
        assert f"a.ana:{2 + row}: expected {names.split()[-1]}, number {number} of the row {names} of {thing}, found the end of the " in said, said
        assert "the deck has 37 numbers, expected 38" in said


@pytest.mark.parametrize("row", [1, 2, 3])
def test_a_missing_row_is_told(row, tmp_path):
    lines = HEAD + MATERIALS
    del lines[1 + row]
    said = refused(tmp_path, lines, GROUP)
    assert "a.ana:5: expected the row vx vy vr of block material 1, found '2600'" in said, said


@pytest.mark.parametrize("row", range(2, len(TABLES + MATERIALS)))  # of the other rows the counts of tables say where they are
def test_a_missing_number_of_shis_order_is_told_with_its_row(row, tmp_path):
    lines = HEAD + TABLES + MATERIALS
    lines[1 + row] = " ".join(lines[1 + row].split()[:-1])
    said = refused(tmp_path, lines, "&deck dialect='shi' /\n", HELD)
    assert f"a.ana:{2 + row}: expected " in said and "found the end of the " in said, said


@pytest.mark.parametrize("geometry, tables", [(FREE, ["1e9"]), (HELD, TABLES)])
def test_a_deck_with_groups_is_read_in_shis_order_where_it_names_that_alone(geometry, tables, tmp_path):
    lines = HEAD + tables + MATERIALS
    said = refused(tmp_path, lines, GROUP, geometry)
    assert "expected" in said and "&deck dialect='shi' /" in said, said
    for groups, options in ((GROUP + "&deck dialect='shi' /\n", ()), (GROUP, ("--set", "deck.dialect=shi")), ("", ())):
        done = check(tmp_path, lines, groups, geometry, *options)
        assert done.returncode == 0 and re.search("^order of the numbers +Shi's, with", done.stdout, re.M), done.stdout + done.stderr


@pytest.mark.parametrize("lines", [HEAD + MATERIALS, [" ".join(HEAD + MATERIALS)], " ".join(HEAD + MATERIALS).split()])
@pytest.mark.parametrize("geometry", [FREE, HELD])
def test_the_short_order_is_told_by_the_count_however_lines_are_parted(geometry, lines, tmp_path):
    for groups in ("", GROUP):
        done = check(tmp_path, lines, groups, geometry)
        assert done.returncode == 0 and re.search("^order of the numbers +short$", done.stdout, re.M), done.stdout + done.stderr


@pytest.mark.parametrize("lines", [HEAD + ["1e9"] + MATERIALS, [" ".join([*HEAD, "1e9", *MATERIALS])],
                                   " ".join([*HEAD, "1e9", *MATERIALS]).split()])
def test_shis_order_without_points_is_told_by_the_count_however_lines_are_parted(lines, tmp_path):
    done = check(tmp_path, lines)
    assert done.returncode == 0 and re.search("^order of the numbers +Shi's, with", done.stdout, re.M), done.stdout + done.stderr


def test_a_run_says_which_order_it_read(tmp_path):
    (tmp_path / "a.geo").write_text(FREE)
    for tables, order in (([], "short"), (["1e9"], "Shi's, with the contact stiffness g0 and a table for each fixed and load point")):
        (tmp_path / "a.ana").write_text("\n".join(HEAD + tables + MATERIALS))
        done = scree.call("run", "a.geo", "a.ana", cwd=tmp_path)
        assert done.returncode == 0 and f"order of the numbers: {order}\n" in done.stdout, done.stdout + done.stderr


@pytest.mark.parametrize("deck", sorted((SOURCE / "input").rglob("*.ana")), ids=lambda path: path.stem)
def test_a_deck_of_the_project_is_in_the_short_order_or_names_its_own(deck):
    text = re.sub("[!#].*", "", deck.read_text())
    numbers, _, groups = text.partition("&")
    numbers = re.split("[ ,\t\n]+", numbers.strip())
    short = 6 + 13 * int(numbers[2]) + 3 * int(numbers[3])
    assert len(numbers) == short or not groups or "dialect='shi'" in groups


GEOMETRY = ["0.001 4 4 0 1 0 0 1 0", "0 0 10 0 1", "10 0 10 4 1", "10 4 0 4 1", "0 4 0 0 1", "1 1 20 1 1e6 0 0", "5 2"]


@pytest.mark.parametrize("row", range(1, len(GEOMETRY)))
def test_a_wrong_row_of_a_geometry_is_told_with_its_line(tmp_path, row):
    """A number too few or too many shifts all that follow it, and the line that alone explains the count is named."""
    for words, told in ((GEOMETRY[row].split()[:-1], "found the end of the"), (GEOMETRY[row].split() + ["3"], "numbers in this line")):
        lines = list(GEOMETRY)
        lines[row] = " ".join(words)
        (tmp_path / "g.geo").write_text("\n".join(lines) + "\n")
        done = scree.call("cut", "g.geo", cwd=tmp_path)
        assert done.returncode == 2
        assert f"g.geo:{row + 1}: expected" in done.stderr and told in done.stderr
