"""Series of a result whose rows are mapped to a file: few readings of the file, bounded memory, the same
bits.
"""

import collections

import numpy as np
import pytest

import vfife
from support import with_settings
from vfife import gallery
from vfife.solvers import record as records
from vfife.solvers.record import CACHED_BYTES, BlockCache, mapping_of, rows_between


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    file = tmp_path_factory.mktemp("run") / "run.sqlite"
    model = with_settings(gallery.four_bar_case_c(), turns=1.0, outputs=500)
    vfife.simulate(model, companions=0, reference=False, file=file)
    return file


def test_all_series_of_a_mapped_record_read_a_block_about_once(path, monkeypatch):
    """Without the cache they read positions and rotations 20 times each. The numbers are those of rows in
    memory.
    """
    expected = vfife.load_result(path).data
    monkeypatch.setattr("vfife.store.run_reader.READ_IN_MEMORY", 0)
    readings, columns_of = collections.Counter(), records.columns_of

    def counted(rows, columns):
        if mapping_of(rows) is not None:
            readings[tuple(columns)] += 1
        return columns_of(rows, columns)

    monkeypatch.setattr(records, "columns_of", counted)
    result = vfife.load_result(path)
    assert mapping_of(result.record.rows) is not None
    data = result.data
    assert readings and sum(readings.values()) < 1.1 * len(readings)
    assert set(data) == set(expected)
    for name in data:
        assert data[name].values.tobytes() == expected[name].values.tobytes(), name


def test_the_cache_is_bounded_and_hands_out_copies():
    rows = records.room_for_rows(CACHED_BYTES // 16, 6, in_memory=0)
    rows[:] = np.arange(6.0)
    assert mapping_of(rows) is not None
    cache = BlockCache(rows)
    for k in range(6):  # a block is half of what the cache holds
        assert (cache.block(str(k), np.array([k])) == k).all()
        assert sum(block.nbytes for block in cache.blocks.values()) <= CACHED_BYTES
    assert list(cache.blocks) == ["4", "5"]
    cache.block("5", np.array([5]))[:] = 0.0
    assert (cache.block("5", np.array([5])) == 5.0).all()
    assert cache.block("wide", np.arange(3)).shape == (len(rows), 3) and "wide" not in cache.blocks


def test_a_small_part_of_mapped_rows_lies_in_memory():
    rows = records.room_for_rows(1000, 4, in_memory=0)
    rows[:] = 1.0
    assert mapping_of(rows_between(rows, 10, 20)) is None and mapping_of(rows_between(rows, 0, 10)) is None
    assert (rows_between(rows, 10, 20) == 1.0).all()
