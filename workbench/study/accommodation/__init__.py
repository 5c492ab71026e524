"""Accommodation studies: a whole population through one workplace, in chunks; gains, comparison."""
