"""Millimetres: from strokes in a photo to a drawing on a page."""
