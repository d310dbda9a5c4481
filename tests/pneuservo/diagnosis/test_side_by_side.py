"""Work done side by side gives what it gives one by one, as it is done where it was asked for."""

import threading
import time

import numpy as np
import pytest

from pneuservo.diagnosis.side_by_side import at_a_time, side_by_side

ITEMS = [3, 1, 2]


@pytest.mark.parametrize("jobs", [1, 2])
def test_answers_are_in_the_order_of_the_items(jobs):
    with at_a_time(jobs):
        assert side_by_side(lambda item: 10 * item, ITEMS) == [30, 10, 20]


def whose(_):
    """Return in which thread a piece of work is done that takes a while."""
    time.sleep(1e-3)
    return threading.get_ident()


class _Count:
    """How many pieces are worked on at the same time, at the most."""

    def __init__(self):
        self._lock, self._now, self.most = threading.Lock(), 0, 0

    def __call__(self, _):
        with self._lock:
            self._now += 1
            self.most = max(self.most, self._now)
        time.sleep(0.01)
        with self._lock:
            self._now -= 1


@pytest.mark.parametrize("jobs", [2, 3])
def test_pieces_of_pieces_are_no_more_at_a_time(jobs):
    count = _Count()
    with at_a_time(jobs):
        side_by_side(lambda _: side_by_side(count, range(4)), range(5))
    assert count.most == jobs


def test_the_pieces_of_the_last_piece_are_shared_out():
    def work(item):
        return set(side_by_side(whose, range(50))) if item == 1 else set()

    with at_a_time(2):
        assert len(side_by_side(work, [0, 1])[1]) == 2


@pytest.mark.parametrize("wrong", range(3))
def test_what_one_piece_raises_is_raised_and_nothing_goes_on(wrong):
    done = []

    def work(item):
        if item == wrong:
            raise ValueError(item)
        done.append(whose(item))

    with at_a_time(2):
        with pytest.raises(ValueError, match=str(wrong)):
            side_by_side(work, range(100))
        assert len(done) < 50
        assert side_by_side(lambda item: item, ITEMS) == ITEMS


def test_what_is_passed_over_here_is_passed_over_in_every_thread():
    with at_a_time(2), np.errstate(divide="raise"), pytest.raises(FloatingPointError):
        side_by_side(lambda item: np.ones(1) / np.zeros(item), [1, 1])


def test_nothing_is_done_beside_when_nothing_says_so():
    assert side_by_side(lambda _: threading.get_ident(), ITEMS) == [threading.get_ident()] * 3
