"""The studio: a browser on this computer goes in, from a photo by way of a drawing to a machine, comes out."""
