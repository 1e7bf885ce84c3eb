"""Hatching, step by step: how dark each place is to be, which way strokes run there, and the strokes."""
