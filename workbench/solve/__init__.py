"""Questions answered on batches of arrays: where the segments are, what touches, how near the joint
stops are."""
