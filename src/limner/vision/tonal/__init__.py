"""Styles that draw the tones of a photo: how much ink goes where, dots, and long strokes along the flow."""
