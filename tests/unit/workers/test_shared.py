"""Tasks that share objects: the objects are not in their bytes, and are the process's own after."""

import pickle

import numpy as np

from pathgene.host.workers.shared import packed, unpacked


def test_shared_objects_are_sent_by_number():
    large, small = np.arange(100_000.0), np.arange(3.0)
    content = packed({"first": large, "again": [large], "own": small}, [large])
    assert len(content) < 1_000 < len(pickle.dumps(large))
    there = large.copy()
    task = unpacked(content, [there])
    assert task["first"] is there
    assert task["again"][0] is there
    np.testing.assert_array_equal(task["own"], small)


def test_the_order_of_shared_objects_counts():
    one, other = np.zeros(2), np.ones(2)
    task = unpacked(packed((other, one), [one, other]), ["one", "other"])
    assert task == ("other", "one")
