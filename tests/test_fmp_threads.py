"""Sharing work out over cores changes neither results nor their order, holds few items, and passes errors on."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from limner.vision.landmarks.fmp import threads


def blas_threads():
    np.ones((2, 2)) @ np.ones((2, 2))
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_results_come_in_order():
    assert list(threads.in_parallel(lambda n: n * n, range(50))) == [n * n for n in range(50)]
    assert list(threads.in_parallel(str, [])) == []


def test_few_items_are_held_at_once(monkeypatch):
    monkeypatch.setattr(threads, "cores", lambda: 3)
    drawn = []
    results = threads.in_parallel(lambda n: n, (drawn.append(n) or n for n in range(100)))
    assert next(results) == 0
    assert len(drawn) == 3
    results.close()


def test_work_runs_beside_each_other(monkeypatch):
    monkeypatch.setattr(threads, "cores", lambda: 2)
    both = threading.Barrier(2, timeout=30)  # passes only if two threads are at work at once
    assert len(list(threads.in_parallel(lambda _: both.wait(), range(2)))) == 2


def test_libraries_use_one_thread_meanwhile_and_as_before_after(monkeypatch):
    before = blas_threads()
    assert list(threads.in_parallel(lambda _: blas_threads(), [0])) == [{1}]
    assert blas_threads() == before


def test_an_error_passes():
    with pytest.raises(ZeroDivisionError):
        list(threads.in_parallel(lambda n: 1 // n, [1, 0]))
