"""Landmarks as found and as refined, and how far each moved: python 06_landmarks.py me.jpg"""

import sys

import numpy as np

import limner

photo = limner.load_photo(sys.argv[1])
for number, face in enumerate(limner.find_faces(photo), 1):
    refined = limner.refine_face(photo, face)
    unit = np.hypot(*(face.points_px[45] - face.points_px[36]))
    moved = np.hypot(*(refined.points_px - face.points_px).T) / unit
    print(f"face {number}: score {face.score:.2f}; landmarks moved by {100 * moved.mean():.1f} % of the eyes' distance")
    limner.save(refined, f"face{number}.json")
