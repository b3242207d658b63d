"""tools/gallery: examples come to the numbers that their decks say, pages print what they quote, and what is off is said."""
import math
import os
import pathlib
import subprocess
import sys

import pytest
import scree
from PIL import Image
from scree import gallery

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
SCENES = gallery.known()
PAGES = {name for name, scene in SCENES.items() if not isinstance(scene, gallery.Example)}
SHOW_WARNINGS = {"joints", "results", "vibration", "when-a-run-stops"}
LONG = {"studies", "quarry"}  # 200 runs; test_study.py and a test below have shorter ones


@pytest.mark.parametrize("name", [name for name in SCENES if name not in LONG])
def test_what_an_example_or_a_page_says_is_so(name, tmp_path):
    rows, _ = gallery.run_in_its_own(SCENES[name], tmp_path, pathlib.Path(os.environ["SCREE"]).absolute())
    assert rows and all(row.holds for row in rows), rows
    if name not in SHOW_WARNINGS:
        for results in sorted((tmp_path / name).glob("*.h5")):
            # falls.h5 shows blocks that move on, and says so
            warnings = [text for text in scree.read(results).warnings if results.name != "falls.h5" or "nothing stops it" not in text]
            assert warnings == [], results
    for picture in SCENES[name].pictures:
        with Image.open(tmp_path / name / picture) as made, Image.open(gallery.PICTURES / picture) as kept:
            assert made.size == kept.size  # and not to the dot: fonts differ
        assert (gallery.PICTURES / picture).stat().st_size < 150e3


def test_the_page_is_that_of_the_decks():
    assert (SOURCE / "doc" / "gallery.md").read_text() == gallery.gallery_page(SCENES.values())


def test_every_folder_of_examples_has_a_deck_of_its_name():
    assert {folder.name for folder in gallery.EXAMPLES.iterdir()} == set(SCENES) - PAGES
    assert len(SCENES) >= 9 + len(PAGES) and {"tutorial", "step-size", "when-a-run-stops"} <= PAGES


SCRIPTS = {name: scene.script for name, scene in SCENES.items() if name not in PAGES and scene.script is not None}


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_scene_in_python_is_short(name):
    """At most 30 lines, and scree and pictures alone are imported beside Python itself."""
    code = [line for line in SCRIPTS[name].splitlines() if line.strip()]
    imported = {line.split()[1].split(".")[0] for line in code if line.startswith(("import ", "from "))}
    assert len(code) <= 30 and imported <= {"scree", "matplotlib", "math"}
    assert SCENES[name].pictures and max(map(len, code)) <= 150


def test_few_rocks_fall_as_many_do(tmp_path):
    script = (gallery.EXAMPLES / "quarry" / "quarry.py").read_text()
    few = tmp_path / "quarry.py"
    few.write_text(script.replace('"number": 200', '"number": 10'))
    done = subprocess.run([sys.executable, few], cwd=tmp_path, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(SOURCE / "tools")})
    assert done.returncode == 0, done.stderr
    shares = [int(line.split(": ")[1]) / 10 for line in done.stdout.splitlines()]
    of_many = [one.value / 200 for one in SCENES["quarry"].expected]
    assert shares == pytest.approx(of_many, abs=0.45) and 0.5 < sum(shares) <= 1  # three deviations of ten rocks
    assert all((tmp_path / picture).exists() for picture in SCENES["quarry"].pictures)


def test_the_slope_is_that_of_its_joint_sets(tmp_path):
    folder = gallery.EXAMPLES / "slope"
    assert scree.call("joints", "slope.joints", "-o", tmp_path / "slope.geo", cwd=folder).returncode == 0
    assert (tmp_path / "slope.geo").read_text() == (folder / "slope.geo").read_text()


def tilt_of_a_column(height, amplitude=0.5 * 9.81, last=0.6, g=9.81, dt=1e-4):
    """Largest tilt of a rigid block, a quarter as wide as high, until it comes back; its base has half a sine of acceleration."""
    alpha, radius = math.atan(0.25), 0.5 * height * math.hypot(1, 0.25)
    tilt = rate = time = largest = 0.0

    def acceleration(time, tilt):
        pushed = amplitude * math.sin(math.pi * time / last) if time < last else 0.0
        return 0.75 * g / radius * (pushed / g * math.cos(alpha - tilt) - math.sin(alpha - tilt))

    while tilt >= 0 and tilt < math.pi / 2 and time < 5:
        a = acceleration(time, tilt)
        if tilt > 0 or a > 0:
            tilt, rate = tilt + dt * rate + dt**2 / 2 * a, rate + dt * acceleration(time + dt / 2, tilt + dt / 2 * rate)
        time, largest = time + dt, max(largest, tilt)
    return largest


def test_columns_tilt_as_rigid_ones_do():
    """The record of the deck has eleven points of the half sine: it pushes 0.8 % less."""
    assert [tilt_of_a_column(height) > 1.5 for height in (1, 2, 4, 8)] == [True, True, False, False]
    said = {one.what: one.value for one in SCENES["toppling"].expected}
    assert said["history/rotation[largest, 3]"] == pytest.approx(tilt_of_a_column(4), rel=0.05)
    assert said["history/rotation[largest, 4]"] == pytest.approx(tilt_of_a_column(8), rel=0.05)


def test_the_slide_on_a_chair_has_the_factor_of_its_equations():
    """Two bodies, in m^2, and what they press on: N on the back, M on the seat, E across the joint between them."""
    back, seat, upper, lower = math.atan(0.8), math.atan(40 / 300), 45750.0, 57000.0

    def lacking(factor):
        """Force along x that the seat lacks; above 0 the slide moves."""
        surface, joint = math.tan(math.radians(12)) / factor, math.tan(math.radians(40)) / factor
        across = math.sin(back) - surface * math.cos(back)       # E = N times this
        N = upper / (math.cos(back) + surface * math.sin(back) + joint * across)
        M = (lower + joint * N * across) / (math.cos(seat) + surface * math.sin(seat))
        return N * across + M * (math.sin(seat) - surface * math.cos(seat))

    low, high = 0.1, 10.0
    for _ in range(60):
        low, high = ((low + high) / 2, high) if lacking((low + high) / 2) < 0 else (low, (low + high) / 2)
    assert SCENES["vajont"].expected[0].value == pytest.approx(low, abs=5e-5)


def test_other_numbers_follow_from_their_formulas():
    said = {name: scene.expected[0].value for name, scene in SCENES.items() if name not in PAGES}
    tangent = {angle: math.tan(math.radians(angle)) for angle in (20, 30, 35, 40)}
    alpha, inner, outer = math.pi / 16, 4.625, 5.375
    arch = 24.525 * (outer**2 - inner**2) / 2 * math.sin(alpha) * 16
    finite = -0.071 - 0.535 * 0.4 + 0.169 * 0.4**2 + 0.02 * 0.4**3 - 1.071 / 0.4 * math.log(0.6)  # the width of the plate
    opening = finite * 4 * 1e6 * 0.4 * (1 - 0.25**2) / 2e10
    yields = (378 * 2400 * 9.81 * tangent[40] - 9810 * 28**2 / 2) / (378 * 2400)  # m/s^2, of a dam of 378 m^2
    speed = slip = 0.0
    for k in range(20000):  # under a ground that moves by 0.6 sin(4 pi t)
        speed = max(0.0, speed + 5e-5 * (-0.6 * 4 * math.pi * math.cos(4 * math.pi * 5e-5 * k) - yields))
        slip += 5e-5 * speed
    assert "slides 106 mm" in SCENES["dam"].expected[1].why and 1000 * slip == pytest.approx(106, abs=0.5)
    assert said["slope"] == pytest.approx(tangent[40] / tangent[35], abs=5e-5)
    assert said["arch"] == pytest.approx(tangent[20] * (arch / 2 + 2.75 * 2 * 24.525) / (0.17657 * arch), abs=2e-4)
    assert said["tunnel"] == pytest.approx(25506 * 5 * 5 / 4)
    assert said["rockfall"] == pytest.approx(-9.81 * 0.8)
    assert said["wall"] == pytest.approx(2.5 * 6 * 24 * tangent[30] / (26 * 5.5**2 / 2 * tangent[30] ** 2), abs=5e-5)
    assert said["cantilever"] == pytest.approx(-1e5 * (10**3 / (3 * 2e10 / 12) + 6 * 10 / (5 * 8e9)))
    assert said["crack"] == pytest.approx(opening, rel=1e-3)


DECK = """! Nothing moves.
!
!     build/release/bin/scree run input/examples/slope/slope.ana -o still.h5 --set step.balance=0.5
!
! Expect:
!     bodies/area[0, largest] = {area} within 1 %: the largest of its blocks
"""


@pytest.mark.parametrize("area, holds", [("12.19", True), ("12.5", False)])
def test_a_number_that_is_off_is_found(area, holds, tmp_path):
    (tmp_path / "still.ana").write_text(DECK.format(area=area))
    rows, _ = gallery.run_in_its_own(gallery.Example(tmp_path / "still.ana"), tmp_path / "run", os.environ["SCREE"])
    assert [row.holds for row in rows] == [holds]


def test_a_command_that_fails_is_found(tmp_path):
    (tmp_path / "still.ana").write_text(DECK.format(area="1").replace("step.balance", "step.sense"))
    rows, _ = gallery.run_in_its_own(gallery.Example(tmp_path / "still.ana"), tmp_path / "run", os.environ["SCREE"])
    assert len(rows) == 1 and "exit status 2: scree: --set step.sense" in rows[0].wrong


@pytest.mark.parametrize("text, said", [("1\n", "expected commands"), ("! Words.\n", "expected commands"),
                                        ("! Expect:\n!     x 1\n", "expected WHAT = NUMBER within NUMBER: WHY")])
def test_a_deck_that_says_nothing_is_refused(text, said, tmp_path):
    (tmp_path / "x.ana").write_text(text)
    with pytest.raises(scree.ScreeError, match=said):
        gallery.Example(tmp_path / "x.ana")


@pytest.mark.parametrize("quoted, holds", [("a 1.0 b", True), ("a 1.0009 b", True), ("a 1.002 b", False), ("a 1.0 c", False),
                                           ("a 1.0 b\n...\nlast 2", True), ("last 2\na 1.0 b", False)])
def test_a_page_is_held_to_what_it_quotes(quoted, holds, tmp_path):
    (tmp_path / "page.md").write_text(f"Words.\n\n```sh\necho 'a  1.0 b'; echo between; echo last 2\n```\n```text\n{quoted}\n```\n")
    rows, _ = gallery.run_in_its_own(gallery.Page(tmp_path / "page.md"), tmp_path / "run", os.environ["SCREE"])
    assert [row.holds for row in rows] == [holds]


@pytest.mark.parametrize("quoted, printed, holds", [("a 1", "a 1", False), (None, "a 1", False), (None, "", False),
                                                    ("scree: no", "scree: no", True), ("a 1\nscree: no", "a 1\nscree: no", True),
                                                    ("scree: yes", "scree: no", False)])
def test_a_command_of_a_page_fails_only_where_an_error_is_quoted(quoted, printed, holds, tmp_path):
    """Also where all that is quoted was printed before it failed."""
    text = f"```text\n{quoted}\n```\n" if quoted else ""
    (tmp_path / "page.md").write_text(f"```sh\nprintf '{printed}'; exit 3\n```\n{text}")
    row, = gallery.run_in_its_own(gallery.Page(tmp_path / "page.md"), tmp_path / "run", os.environ["SCREE"])[0]
    assert row.holds == holds and (quoted == "scree: yes" or holds or row.wrong == f"exit status 3{printed and ': '}{printed}")


def test_the_command_says_what_is_off():
    done = subprocess.run([SOURCE / "tools" / "gallery", "rockfall", "tunnel"], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.endswith("5 of 5 as expected\n"), done.stdout + done.stderr
    done = subprocess.run([SOURCE / "tools" / "gallery", "nothing"], capture_output=True, text=True)
    assert done.returncode == 2 and "expected names out of anchors, arch" in done.stderr
