"""limner: from a photo of a face to a portrait in pen strokes."""
