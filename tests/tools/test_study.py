"""tools/study: one scene with many numbers, also when it is killed, and elsewhere."""
import csv
import itertools
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import matplotlib.pyplot as plt
import numpy as np
import pytest
import scree
from scree.records import explain
from scree.studies import command, picture
from scree.studies.picture import rank_correlation
from scree.studies.runs import Study
from scree.studies.tables import TableError, read_table
from scree.units import Units

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
TOOL = SOURCE / "tools" / "study"
SLIDE = SOURCE / "input" / "validation" / "b1-slide" / "slope30.ana"  # a block on a plane of 30 degrees, g 9.81, for 1 s
TABLE = """deck = "slide.ana"
set = ["step.count=100", "output.every=100"]
[grid]
"joint(1).phi" = [10, 16.5, 20]
"contact.restitution" = { from = 0, to = 0.5, count = 2 }
[quantities]
down = ["measured_points/displacement", -1, 0, 1]
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "slide.ana").write_text(SLIDE.read_text().replace("slope30.blk", str(SLIDE.parent / "slope30.blk")))
    (tmp_path / "slide.toml").write_text(TABLE)
    return tmp_path


def study(folder, *words, status=0):
    done = subprocess.run([TOOL, *words], cwd=folder, capture_output=True, text=True)
    assert done.returncode == status, done.stderr
    return done


def table_of(folder, name="slide"):
    with open(folder / name / "table.csv") as f:
        return list(csv.DictReader(f))


def test_each_run_slides_as_coulomb_says_and_is_made_once(folder):
    done = study(folder, "slide.toml", "--jobs", "2")
    assert done.stdout.startswith("6 runs: 6 complete, 0 ended before, 0 not run; 6 made now")
    rows = table_of(folder)
    assert [(row["joint(1).phi"], row["contact.restitution"]) for row in rows] == [
        (phi, e) for phi in ("10", "16.5", "20") for e in ("0.0", "0.5")]
    for row in rows:
        slope, phi, t = np.radians(30), np.radians(float(row["joint(1).phi"])), 0.2
        along = 9.81 * (np.sin(slope) - np.cos(slope) * np.tan(phi)) * t ** 2 / 2
        assert row["status"] == "complete" and row["steps.taken"] == "100"
        assert float(row["displacement.largest"]) == pytest.approx(along, rel=1e-3)
        assert float(row["down"]) == pytest.approx(-along * np.sin(slope), rel=1e-3)
    before = (folder / "slide" / "table.csv").read_bytes()
    assert "0 made now" in study(folder, "slide.toml").stdout
    assert (folder / "slide" / "table.csv").read_bytes() == before
    (folder / "slide.toml").write_text(TABLE.replace("16.5", "17"))  # what changes is made, what does not is not
    assert "2 made now" in study(folder, "slide.toml").stdout
    (folder / "slide.ana").write_text((folder / "slide.ana").read_text().replace("2500 24525", "2500 24000"))
    assert "6 made now" in study(folder, "slide.toml").stdout


def test_a_static_run_that_finds_no_equilibrium_says_so(folder):
    """The plane dips 30 degrees."""
    (folder / "still.toml").write_text('deck = "slide.ana"\nset = ["deck.k01=0", "step.balance=1e-4"]\n[grid]\n"joint(1).phi" = [29, 31]\n')
    done = study(folder, "still.toml", "--keep")
    assert done.stdout.startswith("2 runs: 1 complete, 1 ended before, 0 not run") and "\nrun 1: moves: block 2 at" in done.stdout
    rows = table_of(folder, "still")
    assert rows[0]["status"].startswith("moves: block 2 at") and rows[1]["status"] == "complete"
    for row in rows:
        (folder / "still" / row["results"]).unlink()
    assert "2 made now" in study(folder, "still.toml", "--keep").stdout


def test_a_table_is_parquet_by_its_name(folder):
    """With the types of its columns, and the numbers of the text."""
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed (pip install pyarrow)")
    (folder / "runs.csv").write_text("joint(1).phi,method.strain,step.size\n30,small,0.01\n95,small,0.01\n20,green,0.01\n")
    words = ["runs.csv", "slide.ana", "--set", "step.count=20"]
    done = study(folder, *words, "--to", "all.parquet")
    assert done.stdout.splitlines()[-1] == str(folder / "all.parquet") and not (folder / "runs" / "table.csv").exists()
    study(folder, *words)
    found, text = parquet.read_table(folder / "all.parquet"), table_of(folder, "runs")
    assert found.column_names == list(text[0]) and found.num_rows == 3
    types = {name: str(found.schema.field(name).type) for name in found.column_names}
    assert types["run"] == types["steps.taken"] == "int64" and types["joint(1).phi"] == types["energy.friction"] == "double"
    assert types["at_rest"] == "bool" and types["method.strain"] == types["status"] == "string"
    for row, line in zip(found.to_pylist(), text):
        assert {name: "" if value is None else str(value) for name, value in row.items() if types[name] != "double"} == {
            name: value for name, value in line.items() if types[name] != "double"}
        assert {name: value for name, value in row.items() if types[name] == "double"} == {
            name: float(value) if value else None for name, value in line.items() if types[name] == "double"}


def test_without_pyarrow_a_name_with_parquet_is_refused_before_any_run(folder):
    (folder / "absent").mkdir()
    (folder / "absent" / "pyarrow.py").write_text("raise ImportError('no pyarrow here')\n")
    done = subprocess.run([TOOL, "slide.toml", "--to", "t.parquet"], cwd=folder, capture_output=True, text=True,
                          env=os.environ | {"PYTHONPATH": str(folder / "absent")})
    assert done.returncode == 2 and done.stderr == ("tools/study: t.parquet: expected the Python package pyarrow, found: no pyarrow here; "
                                                    "pip install '.[parquet]', or give a name with .csv\n")
    assert not list((folder / "slide" / "runs").iterdir())


def test_a_study_that_is_killed_ends_with_the_same_table(folder):
    (folder / "slide.toml").write_text(TABLE.replace("[10, 16.5, 20]", "{ from = 1, to = 25, count = 20 }"))
    study(folder, "slide.toml", "-o", "whole")
    records = folder / "slide" / "runs"
    for number, least in ((signal.SIGKILL, 5), (signal.SIGTERM, 10), (signal.SIGINT, 15)):
        process = subprocess.Popen([TOOL, "slide.toml"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        until = time.monotonic() + 30
        while not records.exists() or len(list(records.glob("*.json"))) < least:
            assert time.monotonic() < until and process.poll() is None
            time.sleep(0.002)
        process.send_signal(number)
        said = process.communicate()[1]
        assert process.returncode == (-9 if number == signal.SIGKILL else 128 + number) and "Traceback" not in said, said
        assert least <= len(list(records.glob("*.json"))) < 40 and not (folder / "slide" / "table.csv").exists()
    made = int(study(folder, "slide.toml").stdout.split("not run; ")[1].split()[0])
    assert 0 < made <= 25
    assert (folder / "slide" / "table.csv").read_bytes() == (folder / "whole" / "table.csv").read_bytes()
    assert not list(records.glob("*.h5"))


def test_numbers_of_the_decks_tell_runs_apart_as_settings_do(folder):
    """What tools/cost_of_accuracy names its records by, too."""
    asked = explain([folder / "slide.ana"], ["joint(1).phi=30", "step.size=0.01"], None)
    assert asked["joint(1).phi"] == "30" and asked["step.size"] == "0.01" and asked["deck.geometry"].endswith("slope30.blk")


def test_a_table_of_lines_and_results_that_are_kept(folder):
    (folder / "runs.csv").write_text("material(2).vx, joint(1).phi\n0.5,30\n\n-0.5, 20\n0,40\n")
    study(folder, "runs.csv", "slide.ana", "--set", "step.count=20", "--keep", "-o", "kept")
    rows = table_of(folder, "kept")
    assert [row["joint(1).phi"] for row in rows] == ["30", "20", "40"]
    results = [scree.read(folder / "kept" / row["results"]) for row in rows]
    assert [list(r.scene.options) for r in results][1] == ["step.count=20", "material(2).vx=-0.5", "joint(1).phi=20"]
    (folder / "kept" / rows[1]["results"]).unlink()
    assert "1 made now" in study(folder, "runs.csv", "slide.ana", "--set", "step.count=20", "--keep", "-o", "kept").stdout


def test_a_geometry_that_the_table_names_counts_with_what_it_says(folder):
    for name in ("slope30", "slope45"):
        (folder / f"{name}.blk").write_text((SLIDE.parent / f"{name}.blk").read_text())
    (folder / "runs.csv").write_text("deck.geometry\nslope30.blk\nslope45.blk\n")
    words = ["runs.csv", "slide.ana", "--set", "step.count=50"]
    assert "2 made now" in study(folder, *words).stdout
    moved = [float(row["displacement.largest"]) for row in table_of(folder, "runs")]
    phi, t = np.radians(16.69924423399362), 0.1
    assert moved == pytest.approx([9.81 * (np.sin(a) - np.cos(a) * np.tan(phi)) * t ** 2 / 2 for a in np.radians([30, 45])], rel=1e-3)
    (folder / "slope45.blk").write_text((folder / "slope45.blk").read_text() + "! another\n")
    assert "1 made now" in study(folder, *words).stdout


PEER = 'PEER\n"Somewhere"\nACCELERATION IN UNITS OF G\nNPTS= 3, DT= .01 SEC\n 0.1 0.2 0.1\n'
MOVES = "0 0 0\n1 1 0\n"
NAMED = {  # by setting: a case, a file, or the text of one, and more of it, ending, settings beside it
    "cover.mesh": ("s1-kirsch/k2-coarse.ana", "quarter8.msh", " ", "msh", []),
    "acceleration.file": ("b1-slide/slope30.ana", MOVES, "2 0 0\n", "txt", []),
    "acceleration.vertical": ("b1-slide/slope30.ana", PEER, " ", "at2", ["acceleration.file=along.at2", "acceleration.scale=9.81"]),
    "absorbing.file": ("w1-wave/p-free.ana", "p-wave.txt", "9 0 0\n", "txt", []),
    "stage(2).acceleration.file": ("b1-slide/slope30.ana", MOVES, "2 0 0\n", "txt", [])}


@pytest.mark.parametrize("by_table", [True, False])
@pytest.mark.parametrize("name", NAMED)
def test_a_file_that_the_table_or_a_setting_names_counts_with_what_it_says(name, by_table, tmp_path):
    """Of two runs that a table gives a file each, one is made anew where its file changes; both where a setting of both names it."""
    case, text, more, ending, beside = NAMED[name]
    case = SOURCE / "input" / "validation" / case
    shutil.copytree(case.parent, tmp_path, dirs_exist_ok=True)
    if name.startswith("stage"):
        (tmp_path / case.name).write_text(case.read_text() + "&stage name='shaken' /\n")
    files = [tmp_path / f"the {number}.{ending}" for number in (1, 2)]
    for file in (*files, tmp_path / "along.at2"):
        file.write_text((case.parent / text).read_text() if (case.parent / text).is_file() else text)
    (tmp_path / "runs.csv").write_text(f"{name}\n{files[0].name}\n{files[1].name}\n" if by_table else "step.count\n1\n2\n")
    settings = [*beside, *(["step.count=1"] if by_table else [f"{name}={files[1].name}"])]
    words = ["runs.csv", case.name, *(word for setting in settings for word in ("--set", setting))]
    assert "2 made now" in study(tmp_path, *words).stdout and "expected" not in (tmp_path / "runs" / "table.csv").read_text()
    assert "0 made now" in study(tmp_path, *words).stdout
    files[1].write_text(files[1].read_text() + more)
    assert f"{1 if by_table else 2} made now" in study(tmp_path, *words).stdout


def test_runs_that_end_before_are_lines_too(folder):
    """A run that fails, one that is refused: the table says why, the study goes on."""
    (folder / "runs.csv").write_text("joint(1).phi,step.size\n30,0.01\n95,0.01\n30,-1\n20,0.01\n")
    done = study(folder, "runs.csv", "slide.ana")
    assert "4 runs: 2 complete, 2 ended before" in done.stdout
    states = [row["status"] for row in table_of(folder, "runs")]
    assert states[0] == states[3] == "complete" and "below 90, found '95'" in states[1] and "above 0, found '-1'" in states[2]


def test_parts_of_an_array_job_make_the_same_table(folder):
    (folder / "slide.toml").write_text(TABLE.replace("[10, 16.5, 20]", "[10]"))
    study(folder, "slide.toml", "-o", "whole")
    assert "2 runs in 2 parts" in study(folder, "slide.toml", "--slurm").stdout
    script = folder / "slide" / "study.sbatch"
    assert "#SBATCH --array=0-1\n" in script.read_text()
    rows = study(folder, "slide.toml", "--collect", status=1).stdout
    assert "2 not run; 0 made now" in rows
    for task in range(2):
        subprocess.run(["bash", script], env=os.environ | {"SLURM_ARRAY_TASK_ID": str(task)}, check=True, cwd="/")
        assert len(list((folder / "slide" / "runs").glob("*.json"))) == task + 1
    assert "0 made now" in study(folder, "slide.toml", "--collect").stdout
    assert (folder / "slide" / "table.csv").read_bytes() == (folder / "whole" / "table.csv").read_bytes()


def test_a_table_of_a_spreadsheet_begins_with_a_mark(folder):
    """UTF-8 with a byte order mark, as spreadsheets write it; names of jobs and files may have blanks."""
    for name, text in (("marked.toml", TABLE.replace("[10, 16.5, 20]", "[10]")), ("with blanks.csv", "joint(1).phi\n10\n")):
        (folder / name).write_text(text, encoding="utf-8-sig")
        words = [name, *(["slide.ana"] if name.endswith("csv") else []), "--slurm"]
        assert " runs in " in study(folder, *words).stdout
    script = (folder / "with blanks" / "study.sbatch").read_text()
    assert '#SBATCH --job-name="with blanks"\n' in script and '/with blanks/slurm-%A_%a.out"\n' in script


def test_a_snakefile_has_the_commands_of_the_parts(folder):
    """Its rules are Python but for their heads; the commands are run here as Snakemake would."""
    (folder / "slide.toml").write_text(TABLE.replace("[10, 16.5, 20]", "[10]"))
    study(folder, "slide.toml", "-o", "whole")
    study(folder, "slide.toml", "--snakemake")
    text = (folder / "slide" / "Snakefile").read_text()
    collect, part = (line.split("shell: ")[1] for line in text.splitlines() if "shell: " in line)
    assert text.splitlines()[1] == "PARTS = 2" and f'output: "{folder}/slide/table.csv"' in text
    for number in range(2):
        command = eval(part).format(wildcards=type("", (), {"part": number}))
        subprocess.run(command, shell=True, check=True, cwd="/")
    subprocess.run(eval(collect), shell=True, check=True, cwd="/", stdout=subprocess.DEVNULL)
    assert (folder / "slide" / "table.csv").read_bytes() == (folder / "whole" / "table.csv").read_bytes()


def test_samples_have_their_distributions_and_their_seed(tmp_path):
    path = tmp_path / "t.toml"
    text = ('[sample]\nnumber=400\nseed=7\n"a.u"={from=-1,to=3}\n"a.l"={from=1e-3,to=1e3,scale="log"}\n'
            '"a.n"={mean=30,deviation=2}\n"a.c"={mean=0,deviation=1,least=0}\n"a.p"=["x","y","z","w"]\n')
    path.write_text(text)
    table = read_table(path)
    columns = dict(zip(table.names, zip(*table.rows)))
    u, logs, n, c = (np.sort(np.array(columns[name], float)) for name in ("a.u", "a.l", "a.n", "a.c"))
    parts = np.arange(401) / 400
    for low, values, high in ((4 * parts[:-1] - 1, u, 4 * parts[1:] - 1), (6 * parts[:-1] - 3, np.log10(logs), 6 * parts[1:] - 3)):
        assert (low - 1e-9 <= values).all() and (values <= high + 1e-9).all()  # one in each part
    assert n.mean() == pytest.approx(30, abs=0.02) and n.std() == pytest.approx(2, rel=0.02)
    assert c.min() >= 0 and c.mean() == pytest.approx(np.sqrt(2 / np.pi), rel=0.01)  # a half of a normal distribution
    assert sorted(columns["a.p"]).count("x") == 100 and len(set(columns["a.p"])) == 4
    assert abs(rank_correlation(np.array(columns["a.u"], float), np.array(columns["a.n"], float))) < 0.15
    assert read_table(path).rows == table.rows
    assert columns["a.u"][:2] == ("-0.6931649427383354", "0.05940002293501756")  # on any machine
    path.write_text(text.replace("seed=7", "seed=8"))
    assert read_table(path).rows != table.rows
    path.write_text(text.replace('"a.p"=["x","y","z","w"]\n', ""))  # a name has numbers of its own
    assert [row[:4] for row in table.rows] == read_table(path).rows


@pytest.mark.parametrize("least, most", [(38, None), (50, None), (60, 60.01), (None, 10), (None, 22), (29, 31), (31, 33), (25, 29), (None, 60)])
def test_samples_of_a_tail_are_within_it(tmp_path, least, most):
    """Each is in its part of equal probability; log Q(z) of the normal distribution, beyond 5 deviations, is -z^2/2 - log(z sqrt(2 pi))
    + log(1 - 1/z^2 + 3/z^4 - 15/z^6 + 105/z^8)."""
    number, ends = 40, {end: value for end, value in (("least", least), ("most", most)) if value is not None}
    words = ",".join(f"{end}={value}" for end, value in {"mean": 30, "deviation": 1, **ends}.items())
    (tmp_path / "t.toml").write_text(f'[sample]\nnumber={number}\n"a.b"={{{words}}}\n')
    values = sorted(float(row[0]) for row in read_table(tmp_path / "t.toml").rows)
    assert ends.get("least", -np.inf) <= values[0] and values[-1] <= ends.get("most", np.inf) and len(set(values)) == number

    def beyond(x):
        """The logarithm of the probability that lies farther out than x, which is beyond both ends or in the tail of one."""
        z = abs(x - 30)
        if z < 5:
            return math.log(math.erfc(z / math.sqrt(2)) / 2)
        return -z * z / 2 - math.log(z * math.sqrt(2 * math.pi)) + math.log(1 - 1 / z ** 2 + 3 / z ** 4 - 15 / z ** 6 + 105 / z ** 8)

    tail = (least or 0) >= 30 or (most or 100) <= 30
    if tail:
        inner, outer = (least, most) if (least or 0) >= 30 else (most, least)
        far = math.exp(beyond(outer) - beyond(inner)) if outer else 0.0
        shares = sorted((math.exp(beyond(x) - beyond(inner)) - far) / (1 - far) for x in values)
        assert all(k - 1e-3 <= number * share <= k + 1 + 1e-3 for k, share in enumerate(shares))


@pytest.mark.parametrize("words, values", [
    ("from=200,to=300,count=3", ["200", "250", "300"]), ("from=1,to=1000,count=4,scale='log'", ["1", "10", "100", "1000"]),
    ("from=0,to=49,count=50", [str(k) for k in range(50)]), ("from=3,to=-3,count=3", ["3", "0", "-3"]),
    ("from=1,to=2,count=3", ["1", "1.5", "2"]), ("from=1.0,to=3,count=3", ["1.0", "2.0", "3.0"])])
def test_what_lies_between_whole_numbers_is_whole_where_it_can_be(tmp_path, words, values):
    """As counts of steps have to be."""
    (tmp_path / "t.toml").write_text(f'[grid]\n"a.b"={{{words}}}\n')
    assert read_table(tmp_path / "t.toml").rows == [[value] for value in values]


def test_a_range_of_counts_is_run(folder):
    (folder / "counts.toml").write_text('deck = "slide.ana"\n[grid]\n"step.count" = { from = 2, to = 6, count = 3 }\n')
    study(folder, "counts.toml")
    assert [row["steps.taken"] for row in table_of(folder, "counts")] == ["2", "4", "6"]


def test_a_grid_meets_each_sample(tmp_path):
    (tmp_path / "t.toml").write_text('[grid]\n"a.x"=[1,2]\n"a.y"={from=1,to=100,count=3,scale="log"}\n'
                                     '[sample]\nnumber=5\n"b.z"={from=0,to=1}\n')
    rows = read_table(tmp_path / "t.toml").rows
    assert len(rows) == 30 and [row[:2] for row in rows[::5]][:3] == [["1", "1"], ["1", "10"], ["1", "100"]]
    assert [row[2] for row in rows[:5]] == [row[2] for row in rows[5:10]]


@pytest.mark.parametrize("text, expected", [
    ("", "at least one run"), ("[grid]\n", "at least one run"), ("x = 1\n", "expected deck, geometry"),
    ("[grid\n", "expected TOML"),
    ('[grid]\n"x"=[1]\n', "names for --set"), ('[grid]\n"a.b"={from=1,to=2}\n', "doc/studies.md .* for a.b without count"),
    ('[grid]\n"a.b"=3\n', "doc/studies.md"),
    ('[grid]\n"a.b"={from=1,to=2,count=1}\n', "from 2"),
    ('[grid]\n"a.b"={count=2}\n', "for a.b without from, to"),
    ('[sample]\nnumber=2\n"a.b"={mean=1}\n', "for a.b without deviation"),
    ('[grid]\n"a.b"={from=1,to=2,count=100000000}\n', "found: count 100000000 of a.b, .* to 100000"),
    ('[sample]\nnumber=100000000\n"a.b"={from=1,to=2}\n', "number .from 1 to 100000."),
    ('[grid]\n"a.b"={from=1,to=2,count=1000}\n"a.c"=[1,2]\n[sample]\nnumber=51\n"a.d"=[1,2]\n',
     "at most 100000 runs, found 102000: 1000 of a.b, 2 of a.c, 51 of number of .sample."),
    ('[grid]\n"a.b"={from=1,to=2,count=2.5}\n', "found: count 2.5 of a.b, which is to be a whole number"),
    ('[grid]\n"a.b"={from="a",to=2,count=2}\n', "found: {'from': 'a', 'to': 2, 'count': 2} for a.b"),
    ('[grid]\n"a.b"={from=true,to=2,count=2}\n', "found: {'from': True, .* for a.b"),
    ('[grid]\n"a.b"=30\n', "found: 30 for a.b"), ('[grid]\n"a.b"="x"\n', "found: 'x' for a.b"),
    ('[grid]\n"a.b"=[]\n', r"found: \[\] for a.b"),
    ('[grid]\na.b=[1]\n', r"found: {'b': \[1\]} for a"), ('[sample]\nnumber=2\n"a.b"={}\n', "found: {} for a.b"),
    ('[sample]\nnumber=2\n"a.b"=30\n', "found: 30 for a.b"),
    ('[sample]\nnumber=2\n"a.b"={mean=1,deviation=[2]}\n', "'deviation': .* for a.b"),
    ('[sample]\nnumber=3\n"a.b"={from=-1,to=2,scale="log"}\n', "above 0"),
    ('[sample]\nnumber=0\n"a.b"=[1]\n', "from 1"), ('[sample]\n"a.b"=[1]\n', "from 1"),
    ('[sample]\nnumber=2\n"a.b"={mean=1,deviation=-1}\n', "deviation is to be above 0"),
    ('[sample]\nnumber=2\n"a.b"={mean=1,deviation=0}\n', "deviation is to be above 0"),
    ('[sample]\nnumber=2\n"a.b"={mean=30,deviation=1,least=31,most=29}\n', "least below most"),
    ('[sample]\nnumber=2\n"a.b"={mean=30,deviation=1,least=31,most=31}\n', "least below most"),
    ('[sample]\nnumber=2\n"a.b"={mean=30,deviation=0.1,least=50}\n', "nothing is left"),
    ('[grid]\n"a.b"=[1]\n[sample]\nnumber=2\n"a.b"=[1]\n', "each once"),
    ('deck=3\n[grid]\n"a.b"=[1]\n', "a text for deck, found 3"), ('set="a.b=1"\n[grid]\n"a.b"=[1]\n', "a list of texts for set, found 'a.b=1'"),
    ('set=[3]\n[grid]\n"a.b"=[1]\n', r"a list of texts for set, found \[3\]"), ('grid=[1]\n', r"a table for grid, found \[1\]"),
    ('[grid]\n"a.b"=[1]\n[quantities]\nx="time"\n', "a dataset and places in it for x of .*, found 'time'"),
    ('[sample]\nnumber=2\n"a.b"=[]\n', r"found: \[\] for a.b")])
def test_a_bad_table_is_one_line(text, expected, tmp_path):
    (tmp_path / "t.toml").write_text(text)
    with pytest.raises(TableError, match=expected) as found:
        read_table(tmp_path / "t.toml")
    assert "\n" not in str(found.value) and "t.toml" in str(found.value)


def test_what_cannot_be_studied_is_one_line(folder):
    (folder / "short.csv").write_text("joint(1).phi,contact.restitution\n30\n")
    (folder / "wrong.csv").write_text("joint(7).phi\n30\n")
    (folder / "quantity.toml").write_text(TABLE.replace('displacement", -1, 0, 1', 'displacement", -1, 9, 1'))
    for words, expected in (
            (["none.csv"], "expected a table of runs"), (["short.csv", "slide.ana"], "expected 2 values in run 1, found 1"),
            (["wrong.csv", "slide.ana"], "joint(1)"), (["wrong.csv"], "expected a deck"),
            (["slide.toml", "none.ana"], "no such file"),
            (["quantity.toml"], "quantity down: expected a dataset"), (["slide.toml", "--draw", "colour"], "displacement.largest"),
            (["slide.toml", "--to", "t.xlsx"], "the ending .csv or .parquet, found '.xlsx'"),
            (["slide.toml", "--to", "none/t.csv"], "expected a folder"), (["slide.toml", "--part", "6/6"], "from 0 to N-1"), (["slide.toml", "--jobs", "0"], "from 1")):
        done = study(folder, *words, status=2)
        assert expected in done.stderr.splitlines()[-1] and "Traceback" not in done.stderr, done.stderr


def test_the_picture_of_a_study(folder):
    done = study(folder, "slide.toml", "--draw", "down")
    picture = folder / done.stdout.splitlines()[-1]
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 10000


MODES = ([], ["--collect"], ["--part", "0/1"], ["--slurm"], ["--snakemake"])
DRAWN = {"down": 0, "displacement.largest": 0, "at_rest": 0, "joint(1).phi": 0, "energy.given": 0,  # exit statuses
         "status": 2, "results": 2, "no such column": 2}


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """A folder with a study of two runs whose results files are kept, so that its records serve every choice of options."""
    folder = tmp_path_factory.mktemp("options")
    (folder / "slide.ana").write_text(SLIDE.read_text().replace("slope30.blk", str(SLIDE.parent / "slope30.blk")))
    (folder / "slide.toml").write_text("""deck = "slide.ana"
set = ["step.count=5", "output.every=5"]
[grid]
"joint(1).phi" = [10, 20]
[quantities]
down = ["measured_points/displacement", -1, 0, 1]
""")
    return folder


def options(mode, *words):
    return [*(["--keep"] if words[0] else []), *(["--units", "mm=1e-3,kPa=1e3"] if words[1] else []), *(["--to", "all.csv"] if words[2] else []),
            *mode, *(["--draw", words[3]] if words[3] else [])]


# Each choice of --keep, --units and --to with each way to run; each column that may be drawn, with results files kept and not.
CHOICES = [(mode, *on, quantity) for mode in MODES for *on, quantity in itertools.product(*3 * [(False, True)], (None, "down", "results"))]
CHOICES += [(MODES[0], keep, False, False, quantity) for keep in (False, True) for quantity in DRAWN]


def test_options_go_together_or_are_refused_in_one_line(studied, monkeypatch, capsys):
    monkeypatch.chdir(studied)
    monkeypatch.setattr(picture, "DPI", 20, raising=False)  # small pictures are as good
    for mode, *choice in CHOICES:
        quantity = choice[3]
        monkeypatch.setattr(sys, "argv", [str(TOOL), "slide.toml", *options(mode, *choice)])
        status = command.main()
        said, case = capsys.readouterr(), (mode, choice)
        writes_a_table = mode in (MODES[0], MODES[1])
        refused = quantity is not None and (not writes_a_table or DRAWN[quantity] == 2)
        assert status == (2 if refused else 0), (case, said.err)
        if refused:
            lines = [line for line in said.err.splitlines() if line.startswith("tools/study: ")]
            assert len(lines) == 1 and "--draw: expected" in lines[0], (case, said.err)
        elif quantity:
            drawn = studied / "slide" / f"{quantity}.png"
            assert drawn.read_bytes().startswith(b"\x89PNG") and said.out.endswith(f"{quantity}.png\n"), case
            drawn.unlink()
        plt.close("all")


@pytest.mark.parametrize("option", ["--slurm", "--snakemake", "--part"])
def test_a_picture_that_cannot_be_drawn_is_refused_before_any_run(folder, option):
    """Where no table is written there is nothing to draw."""
    words = [option, *(["0/1"] if option == "--part" else [])]
    assert "draw with --collect" in study(folder, "slide.toml", "--draw", "down", *words, status=2).stderr
    study(folder, "slide.toml", "--draw", "colour", status=2)
    assert not list((folder / "slide" / "runs").glob("*.json"))


def test_rank_correlation_is_spearmans():
    """1 - 6 sum d^2 / (n (n^2 - 1)) without ties; a law that grows has 1."""
    chance = np.random.default_rng(1)
    x, y = chance.random(50), chance.random(50)
    d = x.argsort().argsort() - y.argsort().argsort()
    assert rank_correlation(x, y) == pytest.approx(1 - 6 * (d ** 2).sum() / (50 * (50 ** 2 - 1)), rel=1e-12)
    assert rank_correlation(x, np.exp(5 * x)) == pytest.approx(1) and rank_correlation(x, -x ** 3) == pytest.approx(-1)
    assert rank_correlation(np.array([1.0, 1, 2, 2]), np.array([5.0, 5, 7, 7])) == pytest.approx(1)
    assert rank_correlation(x, np.ones(50)) == 0


def test_axes_have_dimensions_or_units(folder):
    """Those of numbers of decks and settings as the program says them, of columns of every study, and of quantities, where they have one."""
    (folder / "slide.toml").write_text("""deck = "slide.ana"
set = ["step.count=20", "output.every=20"]
[grid]
"joint(1).c" = [0, 1e3]
"contact.restitution" = [0, 0.5]
[quantities]
down = ["measured_points/displacement", -1, 0, 1]
first = ["VTKHDF/CellData/block", 0]
""")
    study(folder, "slide.toml")
    table = read_table(folder / "slide.toml")
    made = Study(table, [folder / "slide.ana"], [], folder / "slide")
    found = made.dimensions()
    assert found["joint(1).c"] == found["material(2).E"] == "force/length^2" and found["joint(1).phi"] == "degree"
    assert found["step.size"] == found["deck.g1"] == found["time.reached"] == "time" and found["down"] == found["overlap.largest"] == "length"
    assert not {"contact.restitution", "deck.n5", "first", "steps.taken"} & set(found)
    columns = made.header(), made.lines()
    figure = picture.drawn(table.names, *columns, "down", found, Units("mm=1e-3,kPa=1e3"))
    assert [axis.get_xlabel() for axis in figure.axes[:2]] == ["joint(1).c [kPa]", "contact.restitution"]
    assert figure.axes[0].get_ylabel() == "down [mm]" and figure.axes[2].get_ylabel() == "contact.restitution"
    place = columns[0].index("down")
    np.testing.assert_allclose(figure.axes[0].collections[0].get_offsets(),
                               [[float(line[1]) / 1e3, line[place] * 1e3] for line in columns[1]])
    figure = picture.drawn(table.names, *columns, "first", found, Units())
    assert figure.axes[0].get_xlabel() == "joint(1).c [force/length^2]" and figure.axes[0].get_ylabel() == "first"
