"""A checked motion of an arm goes in; the ink that its pen really leaves, and how, comes out."""
