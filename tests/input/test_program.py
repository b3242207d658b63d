"""The program's words, exit statuses and printed tables."""
import os
import pathlib

from scree import call
from scree.house import settings_pages

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
T4 = SOURCE / "input" / "paper" / "rotation" / "t4.ana"


def test_version_and_help():
    assert call("--version").stdout.startswith("scree ")
    done = call("--help")
    assert done.returncode == 0 and "Exit status" in done.stdout


def test_without_words_the_program_says_how_to_call_it():
    done = call()
    assert done.returncode == 2 and done.stdout == ""
    lines = done.stderr.splitlines()
    assert lines[0].startswith("usage: scree COMMAND") and "scree --help" in done.stderr and len(lines) < 15
    for verb in ("check", "run", "cut", "joints", "explain", "estimate"):
        assert any(line.startswith(f"  scree {verb}") for line in lines), verb


def test_wrong_words_are_one_line_and_status_2():
    for words in (["walk"], ["run"], ["run", "a", "b", "c"], ["run", T4, "--fast"], ["run", T4, "--set"], ["check", "--settings"],
                  ["cut", T4], ["cut", T4, "-o", T4], ["cut", "x.geo", "--set", "step.size=1"], ["cut", "x.geo", "--xdmf"],
                  ["cut", "x.geo", "-o", "x.geo"], ["cut", "x.geo", "y.ana", "-o", "x.geo"],
                  ["check", T4, "-o", "x"], ["explain", T4, "--output", "x"], ["estimate", T4, "-o", "x"], ["run", T4, "-o", ""],
                  ["run", T4, "--restart", ""], ["joints", T4, "--set", "step.size=1"], ["--version", "xml"]):
        done = call(*words)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and "expected" in done.stderr, words


def test_check_names_only_the_effects_of_the_scene():
    done = call("check", T4)
    assert done.returncode == 0
    effects = [line.split(" - ")[0].removeprefix("effect: ") for line in done.stdout.splitlines() if line.startswith("effect: ")]
    assert effects == ["inertia", "large deformation", "manifold elements", "initial velocity", "fixed points", "measured points"]


def test_explain_names_every_number_and_where_settings_come_from():
    text = call("explain", T4, "--set", "step.size=0.02").stdout
    for line in ("density (ma): 2500 [mass/length^3]", "initial rotation rate (vr): 6.283185307179586 [rad/time]",
                 "integrator.beta = 0.5 [1]"):
        assert line in text or line.removesuffix(" [1]") in text, line
    assert "step.size = 0.02 [time]  (--set)" in text and "iteration.method = hybrid  (default)" in text
    assert f"method.model = nmm  ({T4}:13)" in text


def test_explain_tells_what_a_setting_means():
    """The same words as the table of all settings; of a group all its settings; another word is a deck."""
    rows, rules = settings_pages.tables(call("explain", "--settings").stdout)
    rows = {row[0].strip("`"): row for row in rows}
    for name in ("contact.restitution", "joints.restitution", "step.size"):
        first, *lines = call("explain", name).stdout.splitlines()
        _, _, unit, default, meaning = rows[name]
        assert first == f"{name}: {meaning}" and f"  default: {default}" in lines
        assert [line for line in lines if line.startswith("  unit: ")] == [f"  unit: {unit}"] * (unit not in ("", "1"))
        about = [why for cell, _, why in rules if any(named == name for named, _ in settings_pages.of_rule(cell))]
        assert [line.rpartition(": ")[2] for line in lines if " only with" in line] == about
    said = [line.split(":")[0] for line in call("explain", "stage").stdout.splitlines() if not line.startswith(" ")]
    assert said == [name for name in rows if name.startswith("stage.")]
    assert call("explain", "contact.bounce").returncode == 2


def test_the_manual_holds_the_table_of_settings():
    for page, text in settings_pages.pages(call("explain", "--settings").stdout).items():
        assert page.read_text() == text, page


def test_a_stem_finds_both_decks(tmp_path):
    (tmp_path / "x.ana").write_text(T4.read_text().replace("&deck geometry='triangle.geo' /", ""))
    (tmp_path / "x.geo").write_text((T4.parent / "triangle.geo").read_text())
    for words in (["x"], ["x.ana"], ["x.geo", "x.ana"]):
        assert call("check", *words, cwd=tmp_path).returncode == 0


def test_the_default_result_lies_here_and_quiet_is_quiet(tmp_path):
    done = call("run", T4, "--quiet", cwd=tmp_path)
    assert done.returncode == 0 and done.stdout == "" and done.stderr == "" and (tmp_path / "t4.h5").exists()


def test_a_log_gets_plain_lines(tmp_path):
    done = call("run", T4, cwd=tmp_path)
    steps = [line for line in done.stdout.splitlines() if line.startswith("left ")]
    assert len(steps) == 10 and "\r" not in done.stdout
