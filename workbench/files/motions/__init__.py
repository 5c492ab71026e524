"""Motion files in and out: every format read into bones, markers, angles or poses, units and faults
told."""
