"""The stand-in for pFUnit, on files that must fail."""
import os
import pathlib
import re
import subprocess
import sys

import pytest

HERE = pathlib.Path(__file__).parent
FC = os.environ.get("FC", "gfortran")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stand_in")
    subprocess.run([FC, "-std=f2008", "-c", HERE / "funit.f90"], cwd=folder, check=True)
    return folder


def translate(source, target):
    return subprocess.run([sys.executable, HERE / "translate_pf.py", source, target], capture_output=True, text=True)


def run(name, folder):
    """Verdict of one file: exit status and all it printed."""
    assert translate(HERE / "must_fail" / name, folder / "t.F90").returncode == 0
    subprocess.run([FC, "-std=f2008", "-ffree-line-length-none", "t.F90", "funit.o", "-o", "t"], cwd=folder, check=True)
    done = subprocess.run(["./t"], cwd=folder, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def test_failures_are_counted_placed_and_end_with_an_error(folder):
    status, text = run("test_failures.pf", folder)
    assert status != 0 and "Tests run: 13, Failures: 12" in text and "FAILURES!!!" in text
    lines = (HERE / "must_fail" / "test_failures.pf").read_text().splitlines()
    marked = [i for i, line in enumerate(lines, 2) if "! fails" in line]
    placed = [int(line.split(":")[1].rstrip("]")) for line in text.splitlines() if line.startswith("  [test_failures.pf:")]
    assert placed == marked  # these, in this order, and none after the first of a test
    assert "the reason in words" in text
    assert "expected  1.0000000000000000E+000, found  2.0000000000000000E+000" in text


def test_after_runs_after_a_failure_and_before_each_test(folder):
    status, text = run("test_before_after.pf", folder)
    assert status != 0
    assert re.findall(r"^[F.]?(before|after)$", text, re.M) == ["before", "after"] * 2


def test_success_is_counted(folder):
    status, text = run("test_success.pf", folder)
    assert status == 0 and "OK" in text and "(2 tests)" in text


@pytest.mark.parametrize("text, expected", [
    ("module m\ncontains\n@unknown\nend module m\n", "t.pf:3: expected a directive"),
    ("module m\ncontains\n@test\ninteger :: i\nend module m\n", "t.pf:4: expected a subroutine after @test"),
    ("module m\ncontains\n@test\nsubroutine s()\n@assertTrue(a, &\nb)\nend subroutine\nend module m\n", "t.pf:5: expected @assertTrue(...)"),
    ("module m\ncontains\n@test\nsubroutine s()\n@assertTrue(a) ! why\nend subroutine\nend module m\n", "t.pf:5: expected @assertTrue(...)"),
    ("module m\nend module m\n", "t.pf: expected a module with an @test")])
def test_what_the_stand_in_does_not_know_is_an_error(text, expected, tmp_path):
    (tmp_path / "t.pf").write_text(text)
    done = translate(tmp_path / "t.pf", tmp_path / "t.F90")
    assert done.returncode == 1 and expected in done.stderr
