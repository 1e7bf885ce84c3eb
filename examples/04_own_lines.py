"""Your own lines on the page, in a good order, for a plotter: python 04_own_lines.py"""

import numpy as np

import limner

turn = np.linspace(0, 2 * np.pi, 60)
petals = [
    np.column_stack([74 + r * np.cos(turn + r), 105 + r * np.sin(turn + r)]) * [1, 1] + np.array([0, 0.2 * r])
    for r in np.arange(5.0, 55.0, 5.0)
]
drawing = limner.Drawing(tuple(petals), ("body",) * len(petals), np.ones(len(petals)), limner.Page())
drawing = limner.order(drawing, limner.Settings().order)
with open("rings.svg", "wb") as file:
    file.write(limner.to_svg(drawing))
print(limner.measure(drawing))
