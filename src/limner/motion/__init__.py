"""A drawing and a machine go in; where the pen is at which time comes out."""
