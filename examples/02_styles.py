"""One photo in several styles; its face is looked for once: python 02_styles.py me.jpg"""

import sys

import limner

session = limner.Session(sys.argv[1])
for style in ("portrait", "gabor", "canny", "splines"):
    portrait = session.draw(style=style, points=500)
    portrait.save(f"{style}.svg")
    print(f"{style}: {len(portrait.drawing.lines_mm)} strokes, likeness {portrait.likeness:.2f}")
