"""Every stage by itself, each result saved: python 03_stages.py me.jpg"""

import sys

import limner

settings = limner.Settings()
photo = limner.load_photo(sys.argv[1])
face = limner.refine_face(photo, limner.find_faces(photo)[0])
limner.save(face, "face.json")

working = limner.to_working_scale(photo, face, settings.scale)  # the face at one size
edges = limner.gabor_edges(working.photo, working.face, settings.gabor)
limner.save(edges, "edges.npz")
strokes = limner.edges_to_strokes(edges, working.face, settings)
limner.save(strokes, "strokes.json")

page = limner.parse_page("a5")
drawing = limner.clean(limner.compose(strokes, page, settings.compose), settings.clean)
drawing = limner.order(limner.select(drawing, settings.select), settings.order)
limner.save(drawing, "drawing.json")
print(f"{len(drawing.lines_mm)} strokes, {drawing.points} points")
