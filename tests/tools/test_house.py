"""tools/check: what it counts and finds, on sources written for it, and on those of src/."""
import os
import pathlib
import re
import shutil

import pytest
from scree.house import ablate, check, fortran, limits, measures, parts, rooms, texts

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"]) / "src"

PROCEDURES = """!> A module; the word subroutine in a comment, and if (x) then
module scree_sample
  use, intrinsic :: iso_fortran_env, only: output_unit
  use scree_kinds, only: dp
  implicit none
  private
  interface
    subroutine dposv(uplo, n, nrhs, a, lda, b, ldb, info)
      character, intent(in) :: uplo
    end subroutine dposv
  end interface

contains

  !> Five own lines, no branch.
  pure real(dp) function plain(a, b) result(c)
    real(dp), intent(in) :: a, b !! both

    ! a comment, if (a > b)
    c = a + &
        b
  end function plain

  subroutine outer(first, &
                   second, & ! a comment within
                   third)
    integer, intent(in) :: first, second(:), third
    integer :: block, where
    character(len=:), allocatable :: text

    text = 'if (a .and. b) then; "do"'//"it's .or. case ('x')"
    rows: do block = 1, first
      if (first > 1 .and. second(1) > 2 .or. third == 0) cycle rows
      if (first == 2) then
        call inner()
      else if (first == 3) then
        exit rows
      else
        where = 3
      end if
    end do rows
    select case (third)
    case (1, 2)
      call inner()
    case default
      return
    end select
  contains
    subroutine inner
      do while (.true.)
        exit
      end do
    end subroutine inner
  end subroutine outer

  recursive logical function last()
    last = .not. .false.
  end function

end module scree_sample
"""


@pytest.fixture
def sample(tmp_path):
    (tmp_path / "sample.f90").write_text(PROCEDURES)
    return tmp_path / "sample.f90"


def test_procedures_are_counted_as_by_hand(sample):
    """Own lines with code, without the procedures inside; 1 + branches, cases, loops, .and., .or."""
    found = {p.name: (len(p.arguments), p.own_lines, p.complexity) for p in fortran.procedures(sample)}
    # outer: do, if, and, or, if, else if, case = 7; `case default`, strings and the variable `where` are none
    assert found == {"plain": (2, 5, 1), "outer": (3, 25, 8), "inner": (0, 5, 2), "last": (0, 3, 1)}
    assert {p.name: p.all_lines for p in fortran.procedures(sample)} == {"plain": 5, "outer": 30, "inner": 5, "last": 3}
    assert {p.full_name() for p in fortran.procedures(sample)} >= {"scree_sample.outer", "scree_sample.inner"}
    assert fortran.modules_used(sample) == [(3, "iso_fortran_env"), (4, "scree_kinds")]


def test_every_procedure_of_the_sources_is_found():
    """As many as there are lines that end one, outside interfaces."""
    for path in SOURCE.rglob("*.f90"):
        text = re.sub(r"(?ms)^ *(abstract )?interface\b.*?^ *end interface\b", "", path.read_text())
        assert len(fortran.procedures(path)) == len(re.findall(r"(?m)^ *end (?:subroutine|function|program)\b", text)), path


def house(folder, uses, declared="scree_room(ground)\nscree_room(middle SEES ground)\n"):
    """Sources of rooms: from a file to the modules that it uses."""
    (folder / "CMakeLists.txt").write_text(f"project(x)\n{declared}add_library(x)\n")
    for name, used in uses.items():
        path = folder / f"{name}.f90"
        path.parent.mkdir(exist_ok=True)
        lines = [f"  use scree_{module}, only: x" for module in used]
        path.write_text("\n".join([f"module scree_{path.stem}", *lines, f"end module scree_{path.stem}", ""]))
    return rooms.arrows(folder), rooms.seen_by(folder)


def test_a_use_of_a_room_above_is_found_at_its_line(tmp_path):
    found, sees = house(tmp_path, {"ground/stone": [], "ground/sand": ["stone", "beam"], "middle/beam": ["stone"],
                                   "roof": ["beam"]})
    assert sees == {"ground": [], "middle": ["ground"], "src": ["ground", "middle"]}
    assert rooms.both_ways(found) == [("ground", "middle")]
    assert [(path.name, line) for path, line, _ in rooms.unlisted(found, sees)] == [("sand.f90", 3)]
    assert list(rooms.unused(found, sees, tmp_path)) == []
    assert list(rooms.picture(found, sees)) == ["ground       -> middle 1 <->", "middle       -> ground 1 <->",
                                                "src          -> middle 1"]


def test_a_use_of_a_lower_room_that_sees_does_not_list_is_found(tmp_path):
    found, sees = house(tmp_path, {"ground/stone": [], "middle/beam": ["stone"], "upper/tile": ["stone", "beam"]},
                        "scree_room(ground)\nscree_room(middle\n  SEES ground)\nscree_room(upper SEES middle)\n")
    assert [(path.name, line) for path, line, _ in rooms.unlisted(found, sees)] == [("tile.f90", 2)]


def test_a_room_that_sees_lists_in_vain_is_found(tmp_path):
    found, sees = house(tmp_path, {"ground/stone": [], "middle/beam": []})
    assert [(path.name, line) for path, line, _ in rooms.unused(found, sees, tmp_path)] == [("CMakeLists.txt", 3)]


def test_a_room_that_is_not_declared_is_named(tmp_path):
    found, sees = house(tmp_path, {"ground/stone": [], "attic/box": ["stone"]})
    assert ["'attic'" in text for *_, text in rooms.unlisted(found, sees)] == [True]


def test_a_procedure_of_a_guarded_room_may_not_be_too_complex(tmp_path):
    for room in ("contact", "input"):
        (tmp_path / room).mkdir()
        (tmp_path / room / f"{room}_x.f90").write_text(
            f"module scree_{room}_x\ncontains\n  subroutine tangled(a)\n    integer :: a\n" + 15 * "    if (a > 0) a = -a\n"
            + f"  end subroutine\nend module scree_{room}_x\n")
    found = measures.all_procedures(tmp_path)
    assert [p.complexity for p in found] == [16, 16]
    assert [(path.name, line) for path, line, _ in measures.too_complex(found, tmp_path, set())] == [("contact_x.f90", 3)]
    assert list(measures.too_complex(found, tmp_path, {"scree_contact_x.tangled"})) == []
    gone = list(measures.too_complex(found, tmp_path, {"scree_contact_x.tangled", "scree_contact_x.mended"}))
    assert ["mended is no longer" in text for *_, text in gone] == [True]


def test_layout_is_compared_but_for_the_indent_of_continuation_lines():
    ours = ["  x = f(a, &", "    b)", "   y = 1", "  z = pack(a, .not. b)", "  call g(open(1))", "  w=2"]
    theirs = ["  x = f(a, &", "        b)", "  y = 1", "  z = pack(a,.not. b)", "  call g(open (1))", "  w = 2"]
    path = pathlib.Path("x.f90")
    assert [line for _, line, _ in check.differences(path, ours, theirs)] == [3, 6]
    assert [line for _, line, _ in check.differences(path, ["x = 1 &", "  +2"], ["x = 1 &", "  + 2"])] == [2]
    assert len(list(check.differences(path, ours, theirs[:-1]))) == 1


def test_the_rooms_use_what_they_list_and_no_guarded_procedure_is_too_complex():
    arrows, sees = rooms.arrows(SOURCE), rooms.seen_by(SOURCE)
    assert len(arrows) > 20 and rooms.both_ways(arrows) == []
    assert list(rooms.unlisted(arrows, sees)) == list(rooms.unused(arrows, sees, SOURCE)) == []
    assert list(measures.too_complex(measures.all_procedures(SOURCE), SOURCE)) == []


GIVEN = """module scree_given
contains
  subroutine change(list, share, n)
    type(list_t), intent(inout) :: list
    real, intent(in) :: share(:)
    integer, value :: n
  end subroutine change
  pure subroutine look(list, share)
    type(list_t), intent(in) :: list
    real, intent(in) :: share(:)
  end subroutine look
  subroutine caller(own, other, i)
    type(list_t), intent(inout) :: own, other
    call change(own, own%share, own%n)
    call change(own, (own%share), own%n)
    call change(own, 2*own%share, own%n)
    call change(own, other%share, own%n)
    call look(own, own%share)
    if (i > 0) call change(own, n=i, share=own%share(:, &
                           i))
    call own%change(own%share, 1)
  end subroutine caller
end module scree_given
"""


def test_something_and_its_part_are_no_two_arguments(tmp_path):
    """Where one may be written; values and expressions are copies."""
    (tmp_path / "given.f90").write_text(GIVEN)
    found = parts.parts_given([tmp_path / "given.f90"])
    assert [line for _, line, _ in found] == [14, 19, 21]
    assert "change is given own and its part own%share" in found[0][2]


NAMES = """module scree_names
  use, intrinsic :: iso_fortran_env, only: output_unit
  use scree_a, only: b, c => d, &
                     operator(+), e ! f, g
  implicit none
  private
  public :: one, two, &
            three
  integer, parameter, public :: four = 4, five(2) = [1, 2]
  integer, parameter :: six = 6
end module scree_names
"""


def test_public_and_imported_names_are_counted_as_by_hand(tmp_path):
    (tmp_path / "names.f90").write_text(NAMES)
    assert fortran.public_names(tmp_path / "names.f90") == 5
    assert fortran.imported_names(tmp_path / "names.f90") == 5


def test_exceptions_to_limits_may_only_fall(tmp_path):
    table, path = tmp_path / "limits.txt", tmp_path / "x.f90"
    table.write_text("# A comment.\nlines scree_x.long 170\npublic scree_x 20\n")
    listed = limits.read(table)
    found = {("lines", "scree_x.long"): (171, path, 9), ("public", "scree_x"): (20, path, 1), ("lines", "scree_x.new"): (151, path, 3)}
    assert [(line, text.split(":")[0]) for _, line, text in limits.beyond(found, listed, table)] == [
        (9, "scree_x.long has 171 lines, above 170"), (3, "scree_x.new has 151 lines, above 150")]
    found = {("lines", "scree_x.long"): (160, path, 9), ("public", "scree_x"): (15, path, 1)}
    assert len(list(limits.beyond(found, listed, table))) == 2
    limits.lower(found, listed, table)
    assert table.read_text() == "# A comment.\nlines scree_x.long 160\n"
    assert list(limits.beyond(found, limits.read(table), table)) == []


@pytest.mark.skipif(shutil.which("mypy") is None, reason="mypy is not installed, so types are not checked")
def test_a_wrong_type_is_found_at_its_line(tmp_path):
    """In a package of the typed modules, of which one returns a text as a number."""
    for name in check.TYPED:
        folder = tmp_path / "tools" / pathlib.Path(*name.split("."))
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "__init__.py").touch()
    assert list(check.types(tmp_path)) == []
    wrong = tmp_path / "tools" / "scree" / "verbs" / "__init__.py"
    wrong.write_text("def plot(what: str) -> int:\n    return what\n")
    (path, line, text), = check.types(tmp_path)
    assert (path, line) == (wrong, 2) and "expected \"int\"" in text


def test_without_mypy_types_are_not_checked_and_that_is_said(monkeypatch, capsys):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert list(check.types(SOURCE.parent)) == [] and "mypy is not installed" in capsys.readouterr().err


def test_the_sources_keep_the_limits():
    found = limits.measured(measures.all_procedures(SOURCE), SOURCE)
    assert list(limits.beyond(found, limits.read())) == []


def test_each_rule_of_the_ablations_is_once_in_the_sources_and_names_unit_tests():
    tests = {path.stem for path in (SOURCE.parent / "tests").rglob("*.pf")}
    for room in ("joints", "contact/laws", "contact/shi"):
        for rule in ablate.rules_of(room):
            assert ablate.without(rule, (SOURCE / rule["file"]).read_text()) != (SOURCE / rule["file"]).read_text()
            assert rule["tests"] and set(rule["tests"]) <= tests
    with pytest.raises(ValueError, match="expected a folder that has rules"):
        ablate.rules_of("solver")


@pytest.mark.parametrize("statement, found", [
    ("line = [line, text_t(label//f(fact))]", True), ("line = [line, text_t('a'//trim(b)//'c')]", True),
    ("x = pair_t(1, a// &\n    f(b))", True), ("call append(line, label//f(fact))", False), ("line = [line, text_t(label//fact)]", False),
    ("line = [(text_t(trim(set(i))), i=1, 2), line]", True), ("type(text_t), allocatable :: a(:)", False), ("x = '//f(' // text_t('a(b)//f(c)')", False)])
def test_texts_that_gfortran_13_miscompiles_are_found(statement, found, tmp_path):
    path = tmp_path / "a.f90"
    path.write_text(statement + "\n")
    assert [line for _, line, _ in texts.made_in_constructors([path])] == [1] * found
