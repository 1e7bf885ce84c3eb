"""Pictures of any kind go in; upright sRGB photos, parts and smaller copies of them come out."""

from limner.vision.photo.crop import Box, crop_photo, shrink_photo
from limner.vision.photo.decode import MAX_PIXELS
from limner.vision.photo.load import Source, load_photo, photo_size

__all__ = ["MAX_PIXELS", "Box", "Source", "crop_photo", "load_photo", "photo_size", "shrink_photo"]
