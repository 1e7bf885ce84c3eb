"""Files: written whole or not at all; every type to and from JSON and npz."""

from limner.storage.fields import STORED, from_fields, from_json, from_npz, load, save, to_fields, to_json, to_npz
from limner.storage.files import make_folder, read_bytes, whole, write_whole
from limner.storage.npz import pack_npz, unpack_npz

__all__ = [
    "STORED",
    "from_fields",
    "from_json",
    "from_npz",
    "load",
    "make_folder",
    "pack_npz",
    "read_bytes",
    "save",
    "to_fields",
    "to_json",
    "to_npz",
    "unpack_npz",
    "whole",
    "write_whole",
]
