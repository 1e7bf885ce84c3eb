"""G-code for a plotter with a Z axis, read back: python 07_gcode.py me.jpg"""

import sys
from pathlib import Path

import limner

portrait = limner.draw(sys.argv[1], points=300)
Path("portrait.gcode").write_bytes(limner.to_gcode(portrait.drawing, limner.GcodeSettings(pen="z")))
again = limner.read_drawing("portrait.gcode")
print(f"{len(portrait.drawing.lines_mm)} strokes written, {len(again.lines_mm)} read back")
