"""What the words of a command line may be, as types for argparse."""
import argparse
import math


def whole_from(least):
    """A whole number from the least."""
    def checked(word):
        if not word.isdecimal() or int(word) < least:
            raise argparse.ArgumentTypeError(f"expected a whole number from {least}, found '{word}'")
        return int(word)
    return checked


def above_zero(word, below=math.inf):
    """A number above 0, such as a time or a length."""
    try:
        value = float(word)
    except ValueError:
        value = 0.0
    if not 0 < value < below:
        limit = f" and below {below:g}" if below < math.inf else ""
        raise argparse.ArgumentTypeError(f"expected a number above 0{limit}, found '{word}'")
    return value
