"""How long a machine takes, and as much as it draws in two minutes: python 05_time.py me.jpg"""

import sys

import limner

session = limner.Session(sys.argv[1])
machine = limner.load_machine("axidraw")

whole = session.draw()
print(f"everything: {limner.costs(whole.drawing, machine).seconds:.0f} s")
short = session.draw(minutes=2, machine="axidraw")
print(f"two minutes: {limner.costs(short.drawing, machine).seconds:.0f} s, {len(short.drawing.lines_mm)} strokes")

path = limner.plan(short.drawing, machine)
middle = path.at(path.t_s[-1] / 2)
print(f"half-way the pen is at {middle}")
