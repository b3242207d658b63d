"""doc/theory: every equation has a label, a procedure and a test that exist; citations lead to equations; figures are drawn and shown."""
import math
import os
import pathlib
import re

import numpy as np
import pytest
from shapely.geometry import Polygon

from scree.figures import contacts, integrators, kinematics, problems
from scree.figures.command import draw
from scree.figures.sheet import FIGURES

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
THEORY = SOURCE / "doc" / "theory"
PAGES = sorted(THEORY.glob("*.md"))
LABEL = re.compile(r"\$\$ \((eq-[a-z-]+)\)")
ROW = re.compile(r"^\| \{eq\}`(?P<label>eq-[a-z-]+)` `(?P=label)` \| `(?P<file>[^`]+)`: `(?P<procedure>[^`]+)` "
                 r"\| `(?P<tests>[^`]+)`: (?:`(?P<test>[^`]+)`|all) \|$", re.M)
CITATION = re.compile(r"doc/theory/([a-z-]+\.md)(?:[,;:]? (?:and )?(eq-[a-z-]+))?")


def labels():
    return [label for page in PAGES for label in LABEL.findall(page.read_text())]


def rows():
    return {row["label"]: row for row in ROW.finditer((THEORY / "equations.md").read_text())}


def test_each_equation_has_a_label_of_its_own_and_a_row():
    text = "".join(page.read_text() for page in PAGES)
    assert len(re.findall(r"(?m)^\$\$", text)) == 2 * len(labels()), "an equation without a label"
    assert len(labels()) == len(set(labels())) > 80
    assert set(labels()) == set(rows())


@pytest.mark.parametrize("label", sorted(set(labels())))
def test_the_procedure_and_the_test_of_an_equation_are_there(label):
    row = rows()[label]
    assert re.search(rf"\b{row['procedure']}\b", (SOURCE / "src" / row["file"]).read_text()), row["procedure"]
    tests = (SOURCE / "tests" / row["tests"]).read_text()
    assert row["test"] is None or re.search(rf"(def|subroutine) {row['test']}\b", tests), row["test"]


def test_equations_that_are_referred_to_are_there():
    for page in PAGES:
        assert set(re.findall(r"\{eq\}`(eq-[a-z-]+)`", page.read_text())) <= set(labels()), page.name


def test_citations_in_the_sources_lead_to_a_page_that_has_the_equation():
    cited = 0
    for file in [*SOURCE.glob("src/**/*.f90"), *SOURCE.glob("tests/**/*.pf")]:
        text = re.sub(r"\n\s*!>? ?", " ", file.read_text())  # citations may go on in the next line of a comment
        for page, label in CITATION.findall(text):
            cited += 1
            assert (THEORY / page).exists(), f"{file.name}: {page}"
            assert not label or label in LABEL.findall((THEORY / page).read_text()), f"{file.name}: {page}, {label}"
    assert cited > 20


def test_every_figure_is_shown_once_with_a_caption_and_every_picture_is_drawn():
    shown = [found for page in PAGES for found in re.findall(r"!\[(.*?)\]\(\.\./pictures/theory/([a-z-]+)\.png\)", page.read_text())]
    assert sorted(name for _, name in shown) == sorted(FIGURES)
    assert sorted(path.stem for path in (SOURCE / "doc/pictures/theory").glob("*")) == sorted(FIGURES)
    assert all(len(caption) > 40 and caption.endswith(".") for caption, _ in shown)


def test_a_figure_is_a_small_picture_and_the_same_each_time(tmp_path):
    first, second = draw("entrance-block", tmp_path / "."), (SOURCE / "doc/pictures/theory/entrance-block.png")
    bits = first.read_bytes()
    assert bits.startswith(b"\x89PNG") and draw("entrance-block", tmp_path).read_bytes() == bits
    assert all(path.stat().st_size < 150_000 for path in second.parent.glob("*.png"))


def convex(random):
    angle = np.sort(random.uniform(0, 2 * math.pi, random.integers(3, 7)))
    return np.column_stack([np.cos(angle), np.sin(angle)]) * random.uniform(0.5, 1.5)


def test_two_convex_bodies_are_apart_where_the_largest_distance_across_an_entrance_line_is_above_0():
    """What chapter 4 says of E(A, B), of the lines that its figures draw."""
    random = np.random.default_rng(1)
    apart = 0
    for _ in range(300):
        A, B = convex(random), convex(random)
        if min(Polygon(A).area, Polygon(B).area) < 0.05:
            continue
        A = A + random.uniform(-2.5, 2.5, 2)
        gap = max(line[1] for line in contacts.entrance_lines(A, B))
        assert (gap > 0) == (not Polygon(A).intersects(Polygon(B)))
        E = Polygon(contacts.entrance_block(A, B, A[0]))
        assert E.contains(Polygon([A[0], A[0] + [1e-9, 0], A[0] + [0, 1e-9]])) == (gap < 0)
        apart += gap > 0
    assert 50 < apart < 250


def test_the_path_of_the_figure_ends_in_a_solution_and_turns_on_the_way():
    points, times, _ = problems.path_from((2.4, 3.0))
    assert np.abs(problems.left_over(points[-1])).max() < 1e-9 and times[-1] == 1 and np.diff(times).min() < 0
    for angle in np.linspace(0, 2 * math.pi, 100):  # far away forces point inward, as the proof says
        at = 10 * np.array([math.cos(angle), math.sin(angle)])
        assert at @ problems.left_over(at) < 0


@pytest.mark.parametrize("matrix, radius", [
    (lambda w: integrators.newmark_matrix(1, 0.5, w), 1), (lambda w: integrators.newmark_matrix(1, 9 / 16, w), 1 / 3),
    (lambda w: integrators.newmark_matrix(0.5, 0.5, w), 1), (lambda w: integrators.generalised_alpha_matrix(0.5, w), 0.5),
    (integrators.bathe_matrix, 0)])
def test_the_roots_that_are_drawn_are_those_of_chapter_3_at_infinite_frequency(matrix, radius):
    assert integrators.radius(matrix(1e8)) == pytest.approx(radius, abs=1e-3)  # a double root is off by the root of rounding


@pytest.mark.parametrize("rotation, area", [("linear", lambda r: 1 + r**2), ("second_order", lambda r: 1 + r**4 / 4),
                                            ("trigonometric", lambda r: 1), ("exact", lambda r: 1)])
def test_the_maps_that_are_drawn_grow_by_the_table_of_chapter_2(rotation, area):
    for r in (1e-3, 0.0628, 0.5):
        assert np.linalg.det(kinematics.map_of(rotation, r)) == pytest.approx(area(r), rel=1e-14)


def test_forces_of_a_friction_problem_obey_the_bound_that_proves_a_solution():
    random = np.random.default_rng(2)
    springs = problems.N0**2 / (4 * problems.STIFFNESS) + problems.T0**2 / (4 * problems.SHEAR_STIFFNESS)
    for _ in range(1000):
        x = random.normal(size=2) * 10 ** random.uniform(-2, 2)
        assert x @ problems.left_over(x) <= x @ problems.LOAD - x @ problems.A @ x + springs + 1e-9 * (1 + x @ x)
