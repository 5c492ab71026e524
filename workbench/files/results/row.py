"""The base of all rows of a result file."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

__all__ = ["Row"]


class Row(BaseModel):
    """A row that has the keys of its class and no others."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)
