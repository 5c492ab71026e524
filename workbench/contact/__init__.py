"""Contact: clearance and contacts of placed bodies, at rest and on the way between poses."""
