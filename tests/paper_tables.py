"""The paper's Tables 1 and 2: numbers, mnemonics and names of segments and joints.

Source: Badler, O'Rourke & Toltzis, "A spherical representation of a human body for visualizing
movement", Proc. IEEE 67(10), 1979.
"""

from __future__ import annotations

__all__ = ["PAPER_JOINTS", "PAPER_SEGMENTS"]

# (number, mnemonic, name)
PAPER_SEGMENTS: tuple[tuple[int, str, str], ...] = (
    (1, "STG", "stage"),
    (2, "LT", "lower torso"),
    (3, "CT", "central torso"),
    (4, "UT", "upper torso"),
    (5, "N", "neck"),
    (6, "H", "head"),
    (7, "LSM", "left shoulder mass"),
    (8, "RSM", "right shoulder mass"),
    (9, "LUA", "left upper arm"),
    (10, "RUA", "right upper arm"),
    (11, "LLA", "left lower arm"),
    (12, "RLA", "right lower arm"),
    (13, "LHN", "left hand"),
    (14, "RHN", "right hand"),
    (15, "LUL", "left upper leg"),
    (16, "RUL", "right upper leg"),
    (17, "LLL", "left lower leg"),
    (18, "RLL", "right lower leg"),
    (19, "LF", "left foot"),
    (20, "RF", "right foot"),
)

# (number, mnemonic, name, proximal segment, distal segment)
PAPER_JOINTS: tuple[tuple[int, str, str, str, str], ...] = (
    (1, "PV", "pelvis", "STG", "LT"),
    (2, "W", "waist", "LT", "CT"),
    (3, "SP", "solar plexus", "CT", "UT"),
    (4, "NP", "neck pivot", "UT", "N"),
    (5, "HP", "head pivot", "N", "H"),
    (6, "LC", "left clavicular joint", "UT", "LSM"),
    (7, "RC", "right clavicular joint", "UT", "RSM"),
    (8, "LS", "left shoulder", "LSM", "LUA"),
    (9, "RS", "right shoulder", "RSM", "RUA"),
    (10, "LE", "left elbow", "LUA", "LLA"),
    (11, "RE", "right elbow", "RUA", "RLA"),
    (12, "LW", "left wrist", "LLA", "LHN"),
    (13, "RW", "right wrist", "RLA", "RHN"),
    (14, "LH", "left hip", "LT", "LUL"),
    (15, "RH", "right hip", "LT", "RUL"),
    (16, "LK", "left knee", "LUL", "LLL"),
    (17, "RK", "right knee", "RUL", "RLL"),
    (18, "LA", "left ankle", "LLL", "LF"),
    (19, "RA", "right ankle", "RLL", "RF"),
)
