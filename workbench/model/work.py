"""Work: what the posture of a person alone cannot say of it."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Literal

from workbench.errors import InputError
from workbench.model.arguments import check_fields
from workbench.model.units import plain

__all__ = ["Work"]


@dataclass(frozen=True)
class Work:
    """What a posture alone cannot say. What is None is assumed, and each score says so.

    Parameters
    ----------
    load
        [kg] in the hands, or the force as the mass of that weight.
    shock, repeated, static, rapid
        Whether the load comes with a shock, the posture repeats more than 4 times a minute, is held
        for longer than 1 minute, or changes fast and far.
    coupling
        How well the hands hold it.
    arms_supported, trunk_supported, legs_balanced
        Whether the arms rest on something, a seat back carries the trunk, and both legs are
        supported alike.
    stance
        What the person stands or sits on; "one_leg" is straight or bent as the posture is.
    """

    load: float | None = None
    shock: bool | None = None
    repeated: bool | None = None
    static: bool | None = None
    rapid: bool | None = None
    coupling: Literal["good", "fair", "poor", "unacceptable"] | None = None
    arms_supported: bool | None = None
    trunk_supported: bool | None = None
    legs_balanced: bool | None = None
    stance: Literal["sitting", "standing", "one_leg", "kneeling", "walking"] | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        if self.load is not None and self.load < 0.0:
            raise InputError(f"work.load: expected 0 kg or more, got {self.load:g}")

    def assumed(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Say which of some values are not stated, and what is taken for each."""
        return tuple(
            f"{plain(name)}: {_ASSUMED[name][1]} (assumed)"
            for name in names
            if getattr(self, name) is None
        )

    def stated(self) -> Work:
        """The same with the assumed values filled in."""
        lacking: dict[str, Any] = {
            field.name: _ASSUMED[field.name][0]
            for field in fields(self)
            if getattr(self, field.name) is None
        }
        return replace(self, **lacking)


_ASSUMED: dict[str, tuple[float | bool | str, str]] = {
    "load": (0.0, "nothing in the hands"),
    "shock": (False, "no shock"),
    "repeated": (False, "at most 4 times a minute"),
    "static": (False, "held for at most 1 minute"),
    "rapid": (False, "no large fast changes"),
    "coupling": ("good", "good"),
    "arms_supported": (False, "no"),
    "trunk_supported": (False, "no"),
    "legs_balanced": (True, "yes"),
    "stance": ("standing", "standing"),
}
"""What is taken where nothing is stated, and its words."""
