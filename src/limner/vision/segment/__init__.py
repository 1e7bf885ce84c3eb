"""Where the parts of a person are in a photo, step by step: places, colours, cut."""
