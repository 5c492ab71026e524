"""What published rules ask of sight: their eye points, outlines, angles, fields and limits."""
