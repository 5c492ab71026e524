"""How functions are compiled that only compiled code calls: see `workbench.compiled`."""

from __future__ import annotations

from workbench.compiled import inlined, inner

__all__ = ["inlined", "inner"]
