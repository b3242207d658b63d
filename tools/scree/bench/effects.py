"""What an effect costs where it is absent, idle or far away: instructions of a step beside the scene without it."""
import dataclasses
import math
import pathlib
import re
import shutil
import subprocess
import tempfile

import numpy as np

from ..block_files import block_file, box, held, turned
from ..errors import RunFailed
from ..program import with_settings
from ..results import read
from .tables import Table

DENSITY, GRAVITY, YOUNG, POISSON, FRICTION, STEP = 2500.0, 9.81, 1e10, 0.25, 30.0, 0.005
RESTITUTION, AWAKE = ["contact.restitution=0"], ["step.sleep=0"]
ABSENT = 1.0  # ratio of an effect that is absent or of zero strength
GROUND, REST, MOVING = 1, 2, 3  # materials: without weight; with it; with a velocity, too
TIMERS = re.compile("scree_timers|scree_random_numbers|system_clock|cpu_time|gettime|scalbn|ldexp|lround")  # and what they call
COLUMNS = [("scene", "scene", "", -46), ("blocks", "blocks", "d", 6), ("unknowns", "unknowns", "d", 8), ("entries", "entries", "d", 7),
           ("solves", "solves", ".2f", 6), ("instructions", "instructions", ".0f", 12), ("allocations", "allocations", ".1f", 11),
           ("ratio", "ratio", ".4f", 8), ("at most", "bound", ".2f", 7)]


@dataclasses.dataclass
class Scene:
    """Blocks (material, corners), those of the ground held by four points each; steps from the first to the last count."""

    blocks: list
    settings: list = dataclasses.field(default_factory=list)
    groups: str = ""
    loads: list = dataclasses.field(default_factory=list)
    measured: list = dataclasses.field(default_factory=list)
    velocity: tuple = (0.0, 0.0, 0.0)
    stress: tuple = (0.0, 0.0, 0.0)
    first: int = 20
    last: int = 120

    def with_more(self, **changes):
        return dataclasses.replace(self, **changes)

    def write(self, folder, name):
        """Writes the decks and returns them."""
        fixed = [point for i, (material, corners) in enumerate(self.blocks, 1) if material == GROUND for point in held(corners[:4], i)]
        geometry, analysis = folder / f"{name}.blk", folder / f"{name}.ana"
        geometry.write_text(block_file(name, self.blocks, fixed, self.loads, self.measured))
        stress, velocity = (" ".join(map(repr, map(float, numbers))) for numbers in (self.stress, self.velocity))
        kinds = [f"{weight!r} {YOUNG} {POISSON} {stress} 0 0 0 {speed}" for weight, speed in (
            (0.0, "0 0 0"), (DENSITY * GRAVITY, "0 0 0"), (DENSITY * GRAVITY, velocity))]
        used = max(material for material, _ in self.blocks)
        analysis.write_text(f"1 {self.last} {used} 1 0.05 {STEP!r}\n" + "".join(f"{DENSITY} {kind}\n" for kind in kinds[:used])
                            + f"{FRICTION} 0 0\n&deck dialect='short' /\n&output every=1000000 /\n{self.groups}\n")
        return [geometry, analysis]


def squares(n, material, height=0.0, apart=4.0, start=0.0):
    """So many squares of 1 m in a row."""
    return [(material, box(start + apart * i, start + apart * i + 1, height, height + 1)) for i in range(n)]


def ground(width, left=-2.0, edges=1):
    """A held block under y = 0, its upper side of so many edges."""
    x = left + width * np.arange(edges, -1, -1) / edges
    return (GROUND, np.array([(left, -1.0), (left + width, -1.0), *((a, 0.0) for a in x)]))


def on_ground(resting, moving=0, apart=4.0, each=100):
    """Squares that rest and squares that slide, on grounds of a hundred each."""
    blocks = []
    for material, n in ((MOVING, moving), (REST, resting)):
        for i in range(0, n, each):
            left = 0.0 if not blocks else blocks[-1][1][:, 0].max() + apart + 6
            count = min(each, n - i)
            blocks += [ground(apart * count + 4, left - 2), *squares(count, material, 0.0, apart, left)]
    return Scene(blocks, velocity=(10.0, 0.0, 0.0), first=60, last=100)


def on_slope(height):
    """A square above a fixed slope of 40 degrees, steeper than its friction."""
    slope = [turned(corners, math.radians(40)) for corners in (box(-50, 50, -10, 0), box(0, 1, height, height + 1))]
    return Scene([(GROUND, slope[0]), (REST, slope[1])])


def cases(size):
    """Rows by the name of the scene without: (name, scene, largest ratio); `size` squares rest in the largest scene."""
    falls = Scene(squares(1, REST))
    alone = falls.with_more(settings=["contact.method=none"])
    rests = on_ground(1)
    rests = rests.with_more(blocks=[ground(4), *rests.blocks[1:]], settings=AWAKE)
    pair = falls.with_more(blocks=squares(2, REST, apart=11.0), settings=alone.settings)
    hundred, hundred_and_one = (on_ground(100, moving).with_more(settings=AWAKE) for moving in (0, 1))
    few, many = max(1, size // 100), size
    far = [(GROUND, box(1000 + 4 * i, 1001 + 4 * i, 0, 1)) for i in range(100)]
    return {
        "a block falls": [
            (falls, "", None),
            (falls.with_more(stress=(1e3, 1e3, 0)), "with an initial stress, which turns", None),
            (falls.with_more(groups="&damping mass=0 /"), "with damping 0", ABSENT),
            (falls.with_more(groups="&acceleration table=0 0 0 1 0 0 /"), "with ground that does not move", ABSENT),
            (falls.with_more(loads=[(0.5, 0.5, 1)], groups="&loads force=0 0 /"), "with a load of no force", ABSENT),
            (falls.with_more(measured=[(0.5, 0.5, 1)]), "with a measured point", None),
            (falls.with_more(settings=RESTITUTION), "with restitution", ABSENT)],
        "a block falls, no contact in the deck": [
            (alone, "", None),
            (alone.with_more(blocks=alone.blocks + far), "beside 100 fixed blocks far away", 1.01),
            (falls.with_more(blocks=falls.blocks + far), "the same with contact", 1.03),
            (on_slope(10), "above a fixed slope, with contact", 2.0),
            (on_slope(0.0), "on a fixed slope, with contact", 4.0)],
        "two blocks fall 10 sizes apart, no contact in the deck": [
            (pair, "", None),
            (pair.with_more(settings=[]), "with contact", 1.03)],
        "a block rests, awake (`step.sleep=0`), on a ground of 4 vertices": [
            (rests, "", None),
            (rests.with_more(blocks=[ground(4000, edges=1000), *rests.blocks[1:]]), "on one of 1003", 1.1),
            (rests.with_more(blocks=rests.blocks + far), "beside 100 fixed blocks far away", 1.25),
            (rests.with_more(settings=AWAKE + RESTITUTION), "with restitution", ABSENT)],
        "100 blocks rest, awake": [
            (hundred, "", None),
            (hundred_and_one, "and one slides elsewhere", None)],
        "a block slides": [
            (on_ground(0, 1), "", None),
            (on_ground(0, 2, each=1), "and another elsewhere", 2.06)],
        f"{few} blocks slide": [
            (on_ground(0, few), "", None),
            (on_ground(many - few, few), f"and {many - few} rest", 10.0),
            (on_ground(many - few, few).with_more(settings=["step.sleep=1e-3"]), "the same with `step.sleep=1e-3`", 3.0)],
    }


class Counter:
    """Counts what a run executes, by valgrind; without it there are no such figures."""

    def __init__(self, program):
        self.program, self.valgrind = program, shutil.which("valgrind")

    def run(self, tool, words):
        done = subprocess.run([self.valgrind, *tool, self.program, *words], capture_output=True, text=True)
        if done.returncode:
            raise RunFailed((done.stderr.splitlines() or [""])[-1], done.returncode, done.stderr)
        return done.stderr

    def instructions(self, words, frame=0):
        """Those of the steps and the looks at what they made, without output; and without those that are not the same each time. Only the
        steps after a frame count; frame 0 is the start. Callgrind writes a profile of what was done before each frame, with a number from
        1 on, and one of the rest, without a number."""
        steps = [f"--toggle-collect=__scree_{name}" for name in ("sleep_MOD_advance_awake", "watch_MOD_watch_step")]
        with tempfile.TemporaryDirectory() as folder:
            profile = pathlib.Path(folder) / "profile"
            self.run(["--tool=callgrind", f"--callgrind-out-file={profile}", "--dump-before=__scree_results_file_MOD_add_frame", *steps], words)
            before = {profile.with_suffix(f".{k}") for k in range(1, frame + 2)}
            return sum(own_instructions(path.read_text()) for path in set(profile.parent.iterdir()) - before)

    def allocations(self, words):
        said = self.run(["--tool=memcheck", "--leak-check=no", "--undef-value-errors=no"], words)
        return int(re.search(r"total heap usage: ([\d,]+) allocs", said)[1].replace(",", ""))


def own_instructions(profile):
    """Instructions in a profile of callgrind but those of the C library, whose allocator takes more or fewer as the heap happens to
    lie, and of the timers of phases, which read the clocks more or less often as time goes. A line of cost is that of the object and
    the function that were named last, or that of a call, after its line calls=."""
    total, names, now, of_call = 0, {}, {}, False
    for line in profile.splitlines():
        named = re.match(r"(c?)(ob|fn)=(\(\d+\))(?: (.*))?$", line)
        if named:
            callee, kind, number, name = named.groups()
            names[kind, number] = name or names.get((kind, number), "")
            if not callee:
                now[kind] = names[kind, number]
        elif line.startswith("calls="):
            of_call = True
        elif line and line[0] in "0123456789+-*":
            if not (of_call or "/libc.so" in now["ob"] or TIMERS.search(now["fn"])):
                total += int(line.split()[-1])
            of_call = False
    return total


def measure(scene, counter, folder, allocations=True):
    """Figures of a step after the first ones of a run, up to the last."""
    decks, output = scene.write(folder, "scene"), folder / "scene.h5"

    def words(steps, *settings):
        output.unlink(missing_ok=True)
        return ["run", *decks, "-o", output, "--quiet", *with_settings([*scene.settings, f"step.count={steps}", *settings])]

    counted = scene.last - scene.first
    row = {"blocks": len(scene.blocks)}
    if counter.valgrind:
        row["instructions"] = counter.instructions(words(scene.last, f"output.every={scene.first}"), frame=1) / counted
        if allocations:
            first, last = (counter.allocations(words(steps)) for steps in (scene.first, scene.last))
            row["allocations"] = (last - first) / counted
    subprocess.run([counter.program, *words(scene.last)], capture_output=True, check=True)
    r = read(output)
    count = dict(zip(r.cost.work, r.cost["count"].tolist()))
    row.update(solves=float(np.mean(r.history.solves[scene.first:])), unknowns=count.get("unknowns"), entries=count.get("entries"))
    return row


def effects(given, folder):
    table, counter = Table(COLUMNS), Counter(given.scree)
    for base, rows in cases(given.size).items():
        without = None
        for scene, what, bound in rows:
            row = measure(scene, counter, folder, given.allocations)
            without = without or row
            row.update(scene=f"  {what}" if what else base, bound=bound)
            if what and "instructions" in row:
                row["ratio"] = row["instructions"] / without["instructions"]
            table.add(row)
    if given.json:
        table.write(given.json, case="effects")
