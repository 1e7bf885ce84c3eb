"""The flexible mixture of parts (thesis 3.2.1): a photo goes in, faces with their landmarks come out."""
