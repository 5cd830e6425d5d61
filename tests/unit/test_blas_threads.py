"""BLAS has one thread while loops are counted, and as many as before afterwards."""

import contextlib

import numpy as np
from threadpoolctl import ThreadpoolController

from lamc.basics.threads import on_one_thread


def blas_threads() -> list[int]:
    return [each["num_threads"] for each in ThreadpoolController().select(user_api="blas").info()]


def test_blas_has_one_thread_within_and_as_many_as_before_afterwards() -> None:
    np.linalg.svd(np.eye(3))  # whose BLAS is there
    with ThreadpoolController().limit(limits=2, user_api="blas"):
        before = blas_threads()
        assert set(on_one_thread(blas_threads)()) == {1}
        assert blas_threads() == before


def test_an_error_within_gives_the_threads_back() -> None:
    @on_one_thread
    def fail() -> None:
        raise ValueError

    with ThreadpoolController().limit(limits=2, user_api="blas"):
        before = blas_threads()
        with contextlib.suppress(ValueError):
            fail()
        assert blas_threads() == before


def test_one_within_another_gives_no_threads_back_before_the_outer_ends() -> None:
    inner = on_one_thread(blas_threads)
    with ThreadpoolController().limit(limits=2, user_api="blas"):
        before = blas_threads()
        for counts in on_one_thread(lambda: (inner(), blas_threads()))():
            assert set(counts) == {1}
        assert blas_threads() == before
