"""A drawing and its photo go in; how much of the person is in the drawing comes out."""
