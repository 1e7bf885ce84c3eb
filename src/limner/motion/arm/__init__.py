"""A drawing, a robot arm and a place for the sheet go in; timed motions of its joints come out."""
