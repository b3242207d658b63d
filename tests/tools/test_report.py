"""tools/report: a page that needs nothing else, and shows in a browser what the results have."""
import json
import os
import pathlib
import re
import subprocess

import h5py
import numpy as np
import pytest
import scree
from browser import CHROMIUM, WITHOUT, Browser
from matplotlib import colormaps
from scree import drawing, overlays, touching
from scree.pages import facts
from scree.pages.frames import pack_frames
from scree.pages.packing import Pack, quantised
from scree.units import Units
from shapely.geometry import Polygon

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
TOOL = SOURCE / "tools" / "report"
SLOPE = SOURCE / "input" / "bench" / "slope" / "reg.geo"
WEAK = """1 60 1 3 0.01 0.005
2600 25506 1e10 0.25 0 0 0 0 0 0 0 0 0
15 0 0
12 0 0
12 0 0
&deck dialect='short' /    ! a remark that is no end: </script><b>&amp;
&output every=6 /
"""
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason=WITHOUT)


def slope(folder):
    (folder / "slope.ana").write_text(WEAK)
    return scree.run(SLOPE, folder / "slope.ana", output=folder / "slope.h5")


def mesh(folder):
    deck = touching.jointed_rock(folder, "nmm", 3, 30)
    return scree.run(deck, output=folder / "mesh.h5", settings=["output.every=6"])


def bolts(folder):
    return scree.run(SOURCE / "input/validation/m10-bolted-block/bolt15.ana", output=folder / "bolts.h5", settings=["output.every=10"])


SCENES = {"slope": slope, "mesh": mesh}


@pytest.fixture(scope="module", params=SCENES)
def page(request, tmp_path_factory):
    """Frames of a run, and its page."""
    results = SCENES[request.param](tmp_path_factory.mktemp(request.param))
    done = subprocess.run([TOOL, results.path], capture_output=True, text=True)
    path = results.path.with_suffix(".html")
    assert done.returncode == 0 and done.stdout == f"{path}\n", done.stderr
    return drawing.Frames(results.path, results.path.stem), path


@pytest.fixture(scope="module")
def shown(page):
    """Frames, and the page in a browser."""
    with Browser() as browser:
        browser.open(page[1])
        yield page[0], browser
        assert not browser.problems


def unpacked(pack, name):
    """An array of a pack, by the words of packing.py."""
    entry, part = pack.directory[name], np.frombuffer(pack.parts[list(pack.directory).index(name)], np.uint8)
    folded = sum(plane.astype(np.int64) << 8 * i for i, plane in enumerate(part.reshape(entry["bytes"], -1)))
    change = np.where(folded % 2, -(folded + 1) // 2, folded // 2)
    return np.cumsum(change.reshape(entry["shape"]), axis=-1)


def test_whole_numbers_are_packed_without_loss():
    rng, pack = np.random.default_rng(4), Pack()
    arrays = {"none": np.zeros((3, 0), int), "one": np.array([-1]), "far": np.array([[2**30 - 1, -2**30, 0], [5, 5, 5]]),
              "many": rng.integers(-200, 200, (7, 2, 11)), "rows": np.arange(300)}
    for name, values in arrays.items():
        pack.add(name, values)
    for name, values in arrays.items():
        np.testing.assert_array_equal(unpacked(pack, name), values, err_msg=name)
    assert pack.directory["rows"]["bytes"] == 1 and len(pack.parts[-1]) == 300  # steps of one


def test_what_is_off_is_at_most_half_a_step():
    series = np.random.default_rng(1).normal(size=(5, 2, 9)) * np.logspace(-9, 9, 5)[:, None, None]
    series[2] = 0
    whole, factor = quantised(series, 100, (1, 2))
    assert np.abs(whole).max() == 100 and factor.shape == (5,)
    assert (np.abs(whole * factor[:, None, None] - series).max(axis=(1, 2)) <= factor / 2 * (1 + 1e-12)).all()


def test_a_page_needs_nothing_else_and_is_small(page):
    text = page[1].read_text()
    assert not re.search(r"(src|href)\s*=|url\(|https?://|import ", text.split("const LOOK")[0])
    assert len(text) < 1e6
    assert text.count("</script>") == 3 and "<b>&amp;" not in text.split('<script type="application/json"')[0].replace("<b>&amp;amp;", "")
    for name in ("Geometry deck", "Analysis deck", "Settings", "Cost", "Energy at the end", "Effects, and why"):
        assert name in text


def test_a_page_says_what_the_run_came_to(page):
    results, text = page[0].file, page[1].read_text()
    assert "The run is complete" in text
    rows = dict(facts.outcome_rows(results, Units()))
    assert rows["steps"].startswith(f"{len(results.history.time)} taken of ") and rows["steps"] in text
    assert f"block {results.summary['overlap']['blocks'][0]} in block" in rows["worst overlap"]
    energy = {name: value for name, value, _ in facts.energy_rows(results, Units())}
    assert set(energy) == set(results.history.energy) and float(energy["friction"].replace(" ", "")) == pytest.approx(
        results.history.energy.friction[-1], rel=1e-3)
    assert [phase for phase, *_ in facts.cost_rows(results)][0] in results.cost.phase[results.cost.share > 0.1]


def test_a_page_says_what_is_of_the_part_since_a_restart(tmp_path):
    results = slope(tmp_path)
    assert facts.since_restart(results, Units()) == ""
    assert scree.call("run", "--restart", results.path, "--set", "step.count=90", "--set", "step.end_time=0.45").returncode == 0
    results = scree.read(results.path)
    said = dict(facts.outcome_rows(results, Units()))["steps"]
    assert len(results.history.time) == 90 and said.startswith("30 taken")  # the program knows of its part alone
    assert subprocess.run([TOOL, results.path]).returncode == 0
    text = results.path.with_suffix(".html").read_text()
    assert "<h2>What it came to since the restart at time 0.3</h2>" in text and "<h2>Cost since the restart at time 0.3</h2>" in text


def test_charts_keep_the_peaks_of_long_runs():
    t = np.linspace(0, 1, 50_000)
    values = np.where(np.arange(50_000) == 12_345, 7.0, np.sin(t))
    made = facts.chart(Units(), t, "x", "1", [("a", values), ("b", -values)])
    assert len(made["steps"]) < 5 * facts.BINS and max(made["series"][0]["values"]) == 7 == -min(made["series"][1]["values"])
    assert made["steps"][0] == 0 and made["steps"][-1] == 1
    assert len(facts.chart(Units(), t[:600], "x", "1", [("a", values[:600])])["steps"]) == 600


def test_remarks_are_on_what_is_off(tmp_path):
    """Small strain at large steps takes rotation for growth: 1 + r^2 in a step."""
    grown = scree.run(SOURCE / "input/paper/rotation/t1.ana", output=tmp_path / "t1.h5")
    level, words, remarks = facts.verdict(grown, Units())
    assert level == "look" and words.startswith("The run is complete") and len(remarks) == 1 and remarks[0].startswith("The blocks grew")
    assert facts.verdict(scree.run(SOURCE / "input/paper/rotation/t4.ana", output=tmp_path / "t4.h5"), Units())[::2] == ("good", [])


def test_what_a_stage_removes_and_steps_tried_again_are_no_fault(tmp_path):
    """A stage digs away one block of three: the others keep their areas to the strain that their weight makes. Notes say what was removed,
    and how many steps were tried again."""
    pillar = scree.run(SOURCE / "input/validation/s3-excavations/pillar.ana", output=tmp_path / "pillar.h5")
    assert np.abs(facts.growth_of_areas(pillar)).max() < 1e-6
    assert facts.verdict(pillar, Units())[::2] == ("good", [])
    assert list(facts.notes_on(pillar, Units("m,Pa,s"))) == ["Stage 2 (dug) removed 1 block with an area of 1 m²."]
    with h5py.File(pillar.path, "a") as f:
        f["history/rejected"][3] = 40
        f["history/area"][300] *= 1.02  # of the blocks that are left
    pillar = scree.read(pillar.path)
    level, _, remarks = facts.verdict(pillar, Units())
    assert level == "look" and len(remarks) == 1 and remarks[0].startswith("The blocks grew by up to 2 % of their area")
    assert next(facts.notes_on(pillar, Units())).startswith("40 steps were tried again with a smaller size, of 403 steps taken.")
    assert subprocess.run([TOOL, pillar.path], capture_output=True).returncode == 0
    text = pillar.path.with_suffix(".html").read_text()
    assert '<ul class="notes"><li>40 steps were tried again' in text and "tries cut" not in text


def test_an_overlap_is_measured_by_the_blocks_that_overlap(tmp_path):
    """A pebble far away makes no overlap of large blocks suspicious."""
    results = scree.run(SOURCE / "input/validation/s3-excavations/pillar.ana", output=tmp_path / "pillar.h5")
    deepest = results.summary["overlap"]
    size, words = facts.size_of_overlapping(results)
    assert size == pytest.approx(np.sqrt(results.bodies.area[0][np.array(deepest["blocks"]) - 1].min()))
    assert words in [f"block {block}" for block in deepest["blocks"]]
    other = next(b for b in range(results.n_blocks) if b + 1 not in deepest["blocks"])
    with h5py.File(results.path, "a") as f:
        f["bodies/area"][:, other] = 1e-20
    assert facts.size_of_overlapping(scree.read(results.path)) == (size, words)


def test_a_run_that_was_killed_has_a_page(tmp_path):
    results = slope(tmp_path)
    with h5py.File(results.path, "a") as f:  # as a killed run leaves it
        del f["ending/summary"], f["ending/warnings"]
        for name in list(f["cost"]):
            del f["cost"][name]
        f["scene"].attrs["status"] = "running"
    done = subprocess.run([TOOL, results.path, "-o", tmp_path / "p.html"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "goes on, or was killed" in (tmp_path / "p.html").read_text()


def test_what_is_no_run_is_one_line(tmp_path):
    (tmp_path / "x.geo").write_text("")
    with h5py.File(tmp_path / "other.h5", "w") as f:
        f["x"] = 1
    cut = tmp_path / "t4.h5"
    scree.cut(SOURCE / "input/paper/rotation/t4.ana", output=cut)
    for words, expected in (([tmp_path / "x.geo"], "expected a results file"), ([tmp_path / "other.h5"], "another HDF5 file"),
                            ([tmp_path / "none.h5"], "found"), ([cut, "-o", tmp_path / "no" / "p.html"], "cannot write")):
        done = subprocess.run([TOOL, *words], capture_output=True, text=True)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and expected in done.stderr, done.stderr
    assert subprocess.run([TOOL, cut], check=False).returncode == 0 and "as set up" in cut.with_suffix(".html").read_text()


@needs_browser
def test_a_page_loads_without_a_problem_or_a_request(shown):
    file, browser = shown
    assert browser.evaluate("document.documentElement.dataset.state") == "ready"
    assert all(url.startswith(("file:", "blob:", "data:", "about:")) for url in browser.requests)
    assert browser.evaluate("player.scene.frames") == len(file.times)
    assert browser.evaluate("document.querySelectorAll('.chart canvas').length") > 10
    assert browser.evaluate("document.querySelectorAll('#solver_charts .chart').length") > 5  # folded
    assert 0 < browser.evaluate("document.querySelectorAll('#charts .chart').length") < 8


@needs_browser
def test_blocks_are_where_the_results_have_them(shown):
    file, browser = shown
    origin = np.array(browser.evaluate("player.scene.origin"))
    frames = (0, len(file.times) // 2, len(file.times) - 1)
    moved = max(np.abs(file.file.vertices(frame) - file.file.vertices(0)).max() for frame in range(len(file.times)))
    off = moved / 8191 / 2 + 2**-30 * np.ptp(file.file.vertices(0))
    for frame in frames:
        found = np.array(browser.evaluate(f"[...player.scene.positions({frame}, 1)]")).reshape(2, -1).T + origin
        np.testing.assert_allclose(found, file.file.vertices(frame), rtol=0, atol=off)
        centre = np.array(browser.evaluate(f"[...player.scene.centroids(player.scene.positions({frame}, 1))]")).reshape(2, -1).T
        np.testing.assert_allclose(centre + origin, overlays.centroids(file, frame), rtol=0, atol=10 * off)  # some are thin


@needs_browser
def test_magnified_blocks_are_farther_from_where_they_began(shown):
    file, browser = shown
    last = len(file.times) - 1
    one, ten, start = (np.array(browser.evaluate(f"[...player.scene.positions({frame}, {factor})]"))
                       for frame, factor in ((last, 1), (last, 10), (0, 1)))
    np.testing.assert_allclose(ten - start, 10 * (one - start), atol=1e-9 * np.abs(ten).max())


@needs_browser
@pytest.mark.parametrize("field", drawing.FIELDS)
def test_fields_are_those_of_pictures(shown, field):
    file, browser = shown
    frame = len(file.times) - 1
    found = np.array(browser.evaluate(f"[...Array(player.scene.elements).keys()].map(e => player.scene.value({frame}, {field!r}, e))"))
    values = file.values(frame, field)[0]
    every = np.concatenate([np.abs(file.file.stress(k)).max(1) for k in range(len(file.times))]).max()
    largest = every if field.startswith(("stress", "major", "minor")) else np.abs(values).max()
    np.testing.assert_allclose(found, values, atol=2e-3 * largest)
    low, high, colours = drawing.limits_of(np.concatenate([file.values(k, field)[0] for k in range(frame + 1)]), field, drawing.Look())
    assert browser.evaluate(f"LOOK.fields.{field}.limits") == pytest.approx([low, high])
    assert browser.evaluate(f"LOOK.fields.{field}.map") == colours


@needs_browser
def test_states_of_joints_are_those_of_pictures(shown):
    """As many parts of each state, of the same length together, at the same places."""
    file, browser = shown
    origin = np.array(browser.evaluate("player.scene.origin"))
    size = np.ptp(file.file.vertices(0), axis=0).max()
    counted = 0
    for frame in range(len(file.times)):
        found = browser.evaluate(f"player.scene.jointParts({frame}, player.scene.positions({frame}, 1))")
        for state, parts in overlays.joint_states(file, frame).items():
            ours = np.array(found[state]).reshape(-1, 2, 2) + origin
            counted += len(parts)
            lengths, true = (np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1) for segments in (ours, parts))
            seen = [np.count_nonzero(those > 1e-5 * size) for those in (lengths, true)]  # corners that touch have parts of no length
            assert abs(seen[0] - seen[1]) <= 0.01 * seen[1], (frame, state)
            assert lengths.sum() == pytest.approx(true.sum(), rel=1e-3, abs=1e-3 * size)
            off = [np.abs(ours.mean(1) - part.mean(0)).max(1).min() for part in parts if len(ours)]
            assert np.quantile(off, 0.95) < 2e-3 * size if off else True
    assert counted > 20


@needs_browser
def test_forces_of_contacts_are_those_of_the_results(shown):
    file, browser = shown
    frame = len(file.times) - 1
    found = np.array(browser.evaluate(f"[...player.scene.contactsOf({frame})].map(c => player.scene.forceOf(c))"))
    true = overlays.contact_forces(file, frame)
    assert len(found) == len(true) > 5
    largest = max(np.abs(overlays.contact_forces(file, k)).max(initial=0) for k in range(frame + 1))
    kept = np.pi / 256 * np.linalg.norm(true, axis=1).sum() + np.sqrt(np.abs(true) * largest).sum() / 511  # of directions, of roots
    np.testing.assert_allclose(found.sum(0), true.sum(0), atol=kept)
    np.testing.assert_allclose(np.sort(np.linalg.norm(found, axis=1)), np.sort(np.linalg.norm(true, axis=1)), atol=0.01 * largest)


def colours_at(browser, places):
    """Colours of the canvas at places of the scene."""
    return np.array(browser.evaluate(f"""{json.dumps(places.tolist())}.map(([x, y]) => {{
        const px = (x - player.scene.origin[0] - player.left) * player.scale;
        const py = player.tall - (y - player.scene.origin[1] - player.below) * player.scale;
        return [...player.pen.getImageData(Math.round(px * player.ratio), Math.round(py * player.ratio), 1, 1).data.slice(0, 3)];
    }})"""))


def widths(file, frame):
    """Of elements: the diameters of circles with the same share of area in the length of the outline."""
    shapes = [Polygon(polygon) for polygon in file.polygons(frame)]
    return np.array([4 * shape.area / shape.length for shape in shapes])


@needs_browser
def test_the_canvas_shows_blocks_in_the_colours_of_the_field(shown):
    file, browser = shown
    browser.evaluate("player.fit()")
    browser.choose("field", "displacement")
    for frame in (len(file.times) - 1, len(file.times) // 2):
        browser.choose("frame", frame)
        values = file.values(frame, "displacement")[0]
        low, high = browser.evaluate("LOOK.fields.displacement.limits")
        expected = 255 * colormaps["cividis"](np.clip((values - low) / (high - low), 0, 1))[:, :3]
        found = colours_at(browser, overlays.centroids(file, frame))
        close = np.abs(found - expected).max(1) < 12
        wide = widths(file, frame) * browser.evaluate("player.scale") > 6  # small elements hide below lines
        assert close[wide].mean() > 0.9 and wide.sum() > 5 and np.ptp(expected, axis=0).max() > 40


@needs_browser
def test_it_plays_zooms_moves_and_tells_what_is_pointed_at(shown):
    file, browser = shown
    browser.choose("field", "block")
    browser.choose("frame", 0)
    browser.evaluate("player.fit(); player.draw(); document.getElementById('play').click()")
    browser.until("player.frame > 3")
    browser.evaluate("document.getElementById('play').click()")
    browser.choose("frame", len(file.times) - 1)
    box = browser.evaluate("(({x, y}) => [x, y])(document.getElementById('scene').getBoundingClientRect())")
    e = int(np.argmax(file.file.bodies.area[0]) if len(file.start) == file.file.n_blocks else 0)
    place = overlays.centroids(file, len(file.times) - 1)[e]
    x, y = browser.evaluate(f"""[({place[0]} - player.scene.origin[0] - player.left) * player.scale + {box[0]},
                                 player.tall - ({place[1]} - player.scene.origin[1] - player.below) * player.scale + {box[1]}]""")
    browser.mouse("mouseMoved", x, y)
    said = browser.until("document.getElementById('pointed').textContent")
    assert said.startswith(f"block {file.file.block[e]} ")
    before = browser.evaluate("[player.scale, player.left]")
    browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-400)
    browser.until(f"player.scale > 1.5 * {before[0]}")
    under = browser.evaluate(f"player.placeOf({x - box[0]}, {y - box[1]})") + np.array(browser.evaluate("player.scene.origin"))
    np.testing.assert_allclose(under, place, atol=2 / before[0])  # what the pointer was at stays there
    left = browser.evaluate("player.left")
    browser.mouse("mousePressed", x, y, button="left", clickCount=1)
    browser.mouse("mouseMoved", x - 50, y, button="left", buttons=1)
    browser.mouse("mouseReleased", x - 50, y, button="left", clickCount=1)
    assert browser.evaluate("player.left") - left == pytest.approx(50 / browser.evaluate("player.scale"), rel=0.05)
    browser.evaluate("document.querySelector('.chart canvas').dispatchEvent(new MouseEvent('click', {}))")  # its left end
    assert browser.evaluate("player.frame") == 0


@needs_browser
def test_all_that_may_be_drawn_over_is_drawn(shown):
    file, browser = shown
    browser.evaluate("player.fit()")
    browser.choose("frame", len(file.times) - 1)
    plain = browser.evaluate("player.canvas.toDataURL()")
    for name, value in (("joints", "state"), ("joints", "forces"), ("vectors", "displacement"), ("vectors", "velocity"),
                        ("crosses", True), ("numbers", True)):
        off = False if value is True else ""
        browser.choose(name, value)
        assert browser.evaluate("player.canvas.toDataURL()") != plain, name
        browser.choose(name, off)
        assert browser.evaluate("player.canvas.toDataURL()") == plain, name
    assert browser.picture().startswith(b"\x89PNG")


def shapes_of_canvases(browser):
    """Width over height of each canvas: of its pixels, and where it is shown."""
    return np.array(browser.evaluate("""[...document.querySelectorAll('canvas')].map(canvas => {
        const box = canvas.getBoundingClientRect();
        return [canvas.width / canvas.height, box.width / box.height];
    })"""))


@needs_browser
def test_paper_distorts_no_picture(page):
    """Paper is narrower than the window, and no script draws a page anew for paper: what was drawn is shown smaller, in its shape."""
    with Browser() as browser:
        browser.open(page[1])
        browser.evaluate("window.sharp = []; window.addEventListener('beforeprint', () => sharp.push(player.canvas.width / player.canvas.clientWidth))")
        assert len(browser.call("Page.printToPDF")["data"]) > 10_000
        assert len(browser.evaluate("sharp")) == 1 and browser.evaluate("sharp[0]") >= 2.9
        browser.call("Emulation.setEmulatedMedia", media="print")
        for width in (700, 400, 1100):
            browser.evaluate(f"document.body.style.width = '{width}px'")
            drawn, shown_as = shapes_of_canvases(browser).T
            np.testing.assert_allclose(shown_as, drawn, rtol=0.02)  # sizes are whole pixels
        assert not browser.problems


@needs_browser
def test_a_window_of_another_size_distorts_no_picture(page):
    with Browser() as browser:
        browser.open(page[1])
        for width in (700, 1500):
            browser.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
            browser.until(f"window.innerWidth === {width} && player.wide === player.canvas.clientWidth")
            drawn, shown_as = shapes_of_canvases(browser).T
            np.testing.assert_allclose(shown_as, drawn, rtol=0.02)
        assert not browser.problems


@needs_browser
def test_bolts_and_points_are_drawn(tmp_path):
    results = bolts(tmp_path)
    assert subprocess.run([TOOL, results.path], check=False).returncode == 0
    file = drawing.Frames(results.path, "bolts")
    with Browser() as browser:
        browser.open(results.path.with_suffix(".html"))
        last = len(file.times) - 1
        ends = np.array(browser.evaluate(f"player.scene.bolts[{last}].ends")).reshape(-1, 2, 2)
        np.testing.assert_allclose(ends, file.bolts(last)[0], rtol=1e-6)
        for kind in np.unique(file.points(0)[0]):
            found = np.array(browser.evaluate(f"player.scene.pointsOf({kind}, player.scene.positions({last}, 1))"))
            found += browser.evaluate("player.scene.origin")
            kinds, places = file.points(last)
            np.testing.assert_allclose(found, places[kinds == kind], atol=1e-4 * np.ptp(file.file.vertices(0)))
        legend = browser.evaluate("document.getElementById('legend').textContent")
        assert legend.startswith("rock 1rock 2bolt") and not browser.problems
        assert browser.evaluate("document.getElementById('scale').hidden")  # rock has names, no bar of colours


@pytest.mark.parametrize("edge", [1e-3, 1.0, 1e3])
def test_places_far_from_the_origin_are_kept(edge, tmp_path):
    """As in maps, whose coordinates are large beside a scene."""
    far = np.array([4e5, 5e6]) * edge
    corners = far + edge * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    lines = "".join(f"{a[0]:.17g} {a[1]:.17g} {b[0]:.17g} {b[1]:.17g} 1\n" for a, b in zip(corners, np.roll(corners, -1, axis=0)))
    (tmp_path / "s.geo").write_text(f"0.001 4 4 0 0 0 0 0 0\n{lines}")
    (tmp_path / "s.ana").write_text(f"1 20 1 1 0.01 0.01\n2500 0 1e9 0.2 0 0 0 0 0 0 {edge} 0 0\n30 0 0\n&deck geometry='s.geo' /\n")
    results = scree.run("s.ana", settings=["output.every=10"], cwd=tmp_path)
    pack, file = Pack(), drawing.Frames(results.path, "s")
    scene = pack_frames(file, pack, Units())
    start = unpacked(pack, "start").T * scene["size"] / 2**30
    moved = unpacked(pack, "motion")[:, :, -1] * scene["motion_factor"][0]
    np.testing.assert_allclose(start + moved, file.file.vertices(-1) - scene["origin"], atol=1e-4 * edge)
    assert np.abs(moved).max() > 0.1 * edge


@needs_browser
def test_what_a_stage_has_removed_is_not_there(tmp_path):
    """Of two blocks on each other the lower is dug away, and what is pointed at there is what comes down."""
    results = scree.run(SOURCE / "input/validation/s3-excavations/pillar.ana", output=tmp_path / "pillar.h5")
    subprocess.run([TOOL, results.path], check=True, capture_output=True)
    there = np.array([results.present(k) for k in range(len(results.times))])
    with Browser() as browser:
        browser.open(results.path.with_suffix(".html"))
        assert browser.evaluate("Array.from(player.scene.gone)") == there.sum(axis=0).tolist()
        last, element = len(there) - 1, int(np.flatnonzero(~there[-1])[0])
        x, y = results.polygons(0)[element].mean(axis=0) - np.array(browser.evaluate("player.scene.origin"))

        def found(frame):
            return browser.evaluate(f"player.scene.elementAt({x}, {y}, player.scene.positions({frame}, 1), {frame})")

        assert found(0) == element != found(last)
        assert not browser.problems


@needs_browser
def test_a_page_has_stages_and_units(tmp_path):
    """Displacements count from where a stage has reset them, also those that are magnified; numbers are in the units, the bar of a scale as
    long as it says."""
    results = scree.run(SOURCE / "tests/data/stages/stages.ana", output=tmp_path / "stages.h5", settings=["output.every=10"])
    done = subprocess.run([TOOL, results.path, "--units", "mm=1e-3,kPa=1e3,ms=1e-3"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    file, last, text = drawing.Frames(results.path, "stages"), results.n_frames - 1, results.path.with_suffix(".html").read_text()
    assert "The run is complete, at time 600 ms." in text and f"{1e3 * results.summary['speed']['largest'] / 1e3:.4g} mm/ms, block 2" in text
    assert "<td>stage 3 (dug)</td><td>dynamic</td><td>complete</td><td>150 steps</td><td>0 ms to 300 ms</td>" in text
    with Browser() as browser:
        browser.open(results.path.with_suffix(".html"))
        assert browser.evaluate("document.getElementById('time').textContent") == f"free, t = 600 ms, frame {last} of {last}"
        browser.choose("frame", 1)
        assert browser.evaluate("document.getElementById('time').textContent").startswith(f"stage 1, step {results.frame_steps[1]}, ")
        e, since = 1, results.counted_from(last)
        moved = np.linalg.norm(results.displacement(last)[results.corners()[e]], axis=1).mean()
        far = np.linalg.norm((results.vertices(last) - results.vertices(0))[results.corners()[e]], axis=1).mean()
        assert since > 0 and moved < 0.8 * far
        assert browser.evaluate(f"player.scene.displacementOf({last}, {e})") == pytest.approx(moved, rel=1e-3)
        file.magnified = 10
        found = np.array(browser.evaluate(f"[...player.scene.positions({last}, 10)]")).reshape(2, -1).T
        np.testing.assert_allclose(found + browser.evaluate("player.scene.origin"), file.vertices(last), atol=2e-3 * moved * 10)
        assert browser.evaluate("LOOK.scales.stress.label") == "principal stress [kPa]"
        assert browser.evaluate("LOOK.scales.displacement.factor") == pytest.approx(1e-3)
        browser.choose("field", "displacement")
        high = browser.evaluate("LOOK.fields.displacement.limits[1]")
        assert float(browser.evaluate("document.getElementById('high').textContent")) == pytest.approx(1e3 * high, rel=1e-3)
        assert not browser.problems
