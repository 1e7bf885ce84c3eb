"""Pixels: from a photo to strokes in it."""
