"""Work done side by side gives what it gives one by one, as it is done where it was asked for."""

import threading

import numpy as np
import pytest

from pneuservo.diagnosis.side_by_side import at_a_time, side_by_side

ITEMS = [3, 1, 2]


def threads_of(_):
    """Return in which threads two pieces of work of a piece of work are done."""
    return set(side_by_side(lambda _: threading.get_ident(), range(2)))


@pytest.mark.parametrize("jobs", [1, 2])
def test_answers_are_in_the_order_of_the_items(jobs):
    with at_a_time(jobs):
        assert side_by_side(lambda item: 10 * item, ITEMS) == [30, 10, 20]


def test_pieces_of_a_piece_are_done_one_by_one():
    both = threading.Barrier(2, timeout=30.0)
    with at_a_time(2):
        # Two that wait for each other are done at the same time, or never.
        side_by_side(lambda _: both.wait(), range(2))
        assert all(len(threads) == 1 for threads in side_by_side(threads_of, ITEMS))


def test_what_is_passed_over_here_is_passed_over_in_every_thread():
    with at_a_time(2), np.errstate(divide="raise"), pytest.raises(FloatingPointError):
        side_by_side(lambda item: np.ones(1) / np.zeros(item), [1, 1])


def test_nothing_is_done_beside_when_nothing_says_so():
    assert side_by_side(lambda _: threading.get_ident(), ITEMS) == [threading.get_ident()] * 3
