"""The painting, step by step: brush strokes from coarse to fine; in colours, or as lines of a few pens."""
