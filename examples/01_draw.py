"""A portrait within a budget of points, as SVG and PNG: python 01_draw.py me.jpg"""

import sys

import limner

portrait = limner.draw(sys.argv[1], points=600)
portrait.save("portrait.svg")
portrait.save("portrait.png")
report = portrait.report()
print(f"{report['strokes']} strokes, {report['ink_mm'] / 1000:.2f} m of ink, likeness {report['likeness']:.2f}")
