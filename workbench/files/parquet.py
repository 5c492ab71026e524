"""Tables as Parquet files, by DuckDB where it is installed."""

from __future__ import annotations

import tempfile
from importlib.util import find_spec
from pathlib import Path

__all__ = ["has_parquet", "parquet_bytes"]


def has_parquet() -> bool:
    """Whether DuckDB, which writes Parquet, is installed."""
    return find_spec("duckdb") is not None


def parquet_bytes(table: str | bytes) -> bytes:
    """A CSV table with a header as a Parquet file; columns of numbers become numbers. The same
    bytes for the same table."""
    import duckdb

    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "table.csv"
        sink = Path(folder) / "table.parquet"
        source.write_bytes(table.encode() if isinstance(table, str) else table)
        with duckdb.connect() as connection:
            connection.execute("SET threads = 1")
            rows = connection.read_csv(
                str(source),
                header=True,
                sep=",",
                quotechar='"',
                escapechar='"',
                skiprows=0,
                sample_size=-1,
            )
            rows.write_parquet(str(sink), compression="zstd")
        return sink.read_bytes()
