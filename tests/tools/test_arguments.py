"""Words of command lines that several tools take: what is a number, what is not, and what is said then."""
import argparse
import functools

import pytest
from scree.arguments import above_zero, whole_from


def test_numbers_are_taken():
    assert [whole_from(1)(word) for word in ("1", "12", "007")] == [1, 12, 7]
    assert [above_zero(word) for word in ("1e-3", "2", " 5 ")] == [1e-3, 2, 5]


@pytest.mark.parametrize("kind,words,said", [
    (whole_from(1), ("0", "-1", "1.5", "x", "", "1e3", "²"), "a whole number from 1"), (whole_from(2), ("1",), "from 2"),
    (above_zero, ("0", "-1", "nan", "inf", "x", ""), "a number above 0, found"),
    (functools.partial(above_zero, below=1000), ("1000", "0"), "above 0 and below 1000")])
def test_what_is_no_such_number_is_refused(kind, words, said):
    for word in words:
        with pytest.raises(argparse.ArgumentTypeError, match=said) as refused:
            kind(word)
        assert f"found '{word}'" in str(refused.value)
