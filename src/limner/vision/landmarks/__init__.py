"""A photo goes in, the faces in it with their landmarks come out."""
