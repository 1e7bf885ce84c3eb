"""The cartoon, step by step: a picture is made simple; its edges, borders and tones become strokes in a few pens."""
