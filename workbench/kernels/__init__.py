"""The compiled code: scalar inline functions, and one batch loop for each query. Nothing else knows the compiler."""

from pathlib import Path

from workbench.kernels.stale import forget_stale

forget_stale(Path(__file__).parent)
