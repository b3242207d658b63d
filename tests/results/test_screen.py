"""What is printed: on terminals of any width, into logs, and where it cannot be written; files of text that are whole or not there."""
import fcntl
import json
import os
import pathlib
import pty
import re
import resource
import signal
import struct
import subprocess
import termios
import time

import pytest
import scree

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
DECK = SOURCE / "input" / "examples" / "toppling" / "toppling.ana"
SLOPE = SOURCE / "input" / "examples" / "slope" / "slope.ana"
JOINTS = "&window x=0 60, y=0 60 /\n&joint_set dip=30, spacing=1, length=4, bridge=1 /\n&joint_set dip=100, spacing=1, length=4, bridge=1 /\n"


def said_on_a_terminal(columns, *words):
    """All bytes that a run writes to a terminal of so many columns."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    run = subprocess.Popen([SCREE, *words], stdin=theirs, stdout=theirs, stderr=subprocess.DEVNULL)
    os.close(theirs)
    said = b""
    while True:
        try:
            said += os.read(ours, 65536)
        except OSError:  # the other end is closed
            break
    os.close(ours)
    assert run.wait() == 0
    return said.decode()


def lines_of_run(said):
    """The lines that a run rewrites on a terminal, without the blanks behind them."""
    return [piece.rstrip() for line in said.splitlines() for piece in line.split("\r") if piece.startswith("left ")]


@pytest.mark.parametrize("columns", [30, 40, 80, 120, 200, 0])
def test_lines_are_no_longer_than_the_terminal_is_wide(columns, tmp_path):
    """Each begins with the time that is left. A terminal that does not say how wide it is has 80 columns."""
    said = said_on_a_terminal(columns, "run", DECK, "-o", tmp_path / "r.h5", "--set", "step.end_time=1")
    steps = lines_of_run(said)
    assert steps and all(re.match(r"left (\d+:\d\d:\d\d|\?)  \d+ %", step) for step in steps), steps
    assert steps[-1].startswith("left 0:00:00  100 %")
    facts = {30: "", 40: "  time 1 of 1", 80: "  time 1 of 1  step 200  moving 5 of 5  dt 0.005"}
    assert steps[-1].removeprefix("left 0:00:00  100 %").partition("  iterations")[0] == facts.get(columns or 80, facts[80])
    assert max(len(piece) for line in said.splitlines() for piece in line.split("\r") if str(tmp_path) not in piece) < (columns or 80)
    log = scree.call("run", DECK, "-o", tmp_path / "r.h5", "--set", "step.end_time=1").stdout.splitlines()
    whole = [line for line in log if not line.startswith(("left ", "time: "))]  # of the others the clock is a part
    assert len(whole) > 8 and all(line in " ".join(said.split()) for line in whole)


def test_a_log_has_a_line_for_each_tenth_of_the_run(tmp_path):
    """Of all stages together, and of a part that --restart goes on with. Shares never fall."""
    stages = SOURCE / "tests" / "data" / "stages" / "stages.ana"
    for words in (["run", DECK, "--set", "step.end_time=1"], ["run", stages]):
        log = scree.call(*words, "-o", tmp_path / "r.h5").stdout.splitlines()
        shares = [int(line.split()[2]) for line in log if line.startswith("left ")]
        assert shares == sorted(shares) and shares[-1] == 100 and 3 <= len(shares) <= 11, log
    scree.call("run", DECK, "-o", tmp_path / "r.h5", "--steps", "95", "--set", "step.end_time=1")
    log = scree.call("run", "--restart", tmp_path / "r.h5").stdout.splitlines()
    assert [int(line.split()[2]) // 10 for line in log if line.startswith("left ")] == [5, 6, 7, 8, 9, 10]


def test_a_static_run_says_its_unbalanced_force_and_which_blocks_move(tmp_path):
    said = said_on_a_terminal(40, "run", SLOPE, "-o", tmp_path / "r.h5")
    last, r = lines_of_run(said)[-1], scree.read(tmp_path / "r.h5")
    found = re.fullmatch(r"left 0:00:00  100 %  unbalanced (\S+)", last)
    assert found and float(found[1]) == pytest.approx(r.history.unbalanced[-1], rel=0.05)
    log = [line for line in scree.call("run", SLOPE, "-o", tmp_path / "r.h5").stdout.splitlines() if line.startswith("left ")]
    assert all(re.search(r"%  unbalanced \S+  step \d+  moving \d+ of \d+  iterations \d+$", line) for line in log), log
    moving = [int(re.search(r"moving (\d+)", line)[1]) for line in log]
    assert moving[0] > 0 and moving[-1] == 0


def test_moving_blocks_are_those_not_at_rest(tmp_path):
    """A rock that falls, and comes to rest."""
    log = scree.call("run", SOURCE / "input" / "examples" / "rockfall" / "rockfall.ana", "-o", tmp_path / "r.h5").stdout.splitlines()
    moving = [re.search(r"moving (\d of \d)", line)[1] for line in log if line.startswith("left ")]
    assert moving[0] == "1 of 1" and moving[-1] == "0 of 1", moving


@pytest.mark.parametrize("words", [["run", DECK, "--quiet", "--summary", "json"], ["run", DECK]])
def test_what_a_run_came_to_that_cannot_be_written_is_an_error(words, tmp_path):
    path = tmp_path / "r.h5"
    with open("/dev/full", "w") as full:
        done = subprocess.run([SCREE, *words, "-o", path, "--set", "step.end_time=0.1"], stdout=full, stderr=subprocess.PIPE, text=True)
    last = done.stderr.splitlines()[-1]
    assert done.returncode == 1 and last.startswith("scree: standard output: cannot write: No space left on device; ") and str(path) in last
    results = scree.read(path)
    assert results.scene.status == "complete" and results.summary["status"] == "complete" and results.n_frames > 1


def test_a_quiet_run_needs_no_standard_output(tmp_path):
    with open("/dev/full", "w") as full:
        done = subprocess.run([SCREE, "run", DECK, "-o", tmp_path / "r.h5", "--quiet", "--set", "step.end_time=0.1"], stdout=full)
    assert done.returncode == 0


def test_a_summary_is_one_line_on_any_terminal(tmp_path):
    said = said_on_a_terminal(40, "run", DECK, "-o", tmp_path / "r.h5", "--quiet", "--summary", "json", "--set", "step.end_time=0.1")
    assert json.loads(said)["status"] == "complete" and len(said.splitlines()) == 1


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """A geometry of some thousand blocks, and the deck that it is drawn from."""
    folder = tmp_path_factory.mktemp("many")
    (folder / "many.joints").write_text(JOINTS)
    assert scree.call("joints", "many.joints", "-o", "many.geo", "--quiet", cwd=folder).returncode == 0
    return folder


def limit_file_size():
    """Writes beyond 20 kB fail, as on a full disk."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))


@pytest.mark.parametrize("words, output", [(["cut", "many.geo"], "out.blk"), (["joints", "many.joints"], "out.geo")])
def test_a_text_file_is_there_whole_or_not_at_all(words, output, many, tmp_path):
    """A disk that is full is an error, and leaves what there was before."""
    for before in (None, "whole"):
        done = scree.call(*words, "-o", tmp_path / output, "--quiet", cwd=many, preexec_fn=limit_file_size)
        assert done.returncode == 1 and done.stderr == f"scree: {tmp_path / output}: cannot write: File too large\n"
        assert [path.name for path in tmp_path.iterdir()] == ([output] if before else [])
        assert scree.call(*words, "-o", tmp_path / output, "--quiet", cwd=many).returncode == 0
        whole = (tmp_path / output).read_bytes()
        assert len(whole) > 50_000
    done = scree.call(*words, "-o", tmp_path / output, "--quiet", cwd=many, preexec_fn=limit_file_size)
    assert done.returncode == 1 and (tmp_path / output).read_bytes() == whole


@pytest.mark.parametrize("words, output", [(["cut", "many.geo"], "out.blk"), (["joints", "many.joints"], "out.geo")])
def test_what_was_stopped_as_it_wrote_is_written_once_more(words, output, many, tmp_path):
    for kill in (signal.SIGKILL, signal.SIGTERM):
        going = subprocess.Popen([SCREE, *words, "-o", tmp_path / output, "--quiet"], cwd=many)
        while not list(tmp_path.iterdir()) and going.poll() is None:
            time.sleep(0.001)
        going.send_signal(kill)
        going.wait()
        done = scree.call(*words, "-o", tmp_path / output, "--quiet", cwd=many)
        assert done.returncode == 0 and [path.name for path in tmp_path.iterdir()] == [output], done.stderr
        (tmp_path / output).unlink()


def test_a_block_file_goes_where_a_link_leads_and_into_pipes(many, tmp_path):
    (tmp_path / "link.blk").symlink_to("there.blk")
    assert scree.call("cut", many / "many.geo", "-o", tmp_path / "link.blk", "--quiet").returncode == 0
    assert (tmp_path / "link.blk").is_symlink()
    piped = subprocess.run(f"{SCREE} cut {many / 'many.geo'} -o /dev/stdout --quiet | cat", shell=True, capture_output=True)
    assert piped.stdout == (tmp_path / "there.blk").read_bytes()
