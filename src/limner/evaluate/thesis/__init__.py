"""Free portraits and annotated photos in; the thesis followed chapter by chapter, ours beside its, out."""
