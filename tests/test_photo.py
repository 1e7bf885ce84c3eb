"""Any picture that people have becomes the same upright sRGB photo, and anything else one clear line."""

import io
import struct
import sys
import warnings
import zlib

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from PIL import Image, ImageCms

from limner.errors import BadInput, MissingExtra
from limner.types import Photo
from limner.vision.photo import MAX_PIXELS, crop_photo, load_photo, pixels


def picture(width=40, height=24):
    """Four flat quarters, all different, so that every flip and turn shows and JPEG keeps it."""
    rgb = np.zeros((height, width, 3), np.uint8)
    rgb[: height // 2, : width // 2] = (220, 40, 40)
    rgb[: height // 2, width // 2 :] = (40, 200, 60)
    rgb[height // 2 :, : width // 2] = (50, 60, 210)
    rgb[height // 2 :, width // 2 :] = (240, 230, 60)
    return rgb


def encoded(image, kind, **options):
    out = io.BytesIO()
    image.save(out, kind, **options)
    return out.getvalue()


def heic(image, **options):
    pillow_heif = pytest.importorskip("pillow_heif", reason="needs pillow-heif; run: pip install 'limner[heic]'")
    pillow_heif.register_heif_opener()
    return encoded(image, "HEIF", quality=95, **options)


def near(photo, rgb, tolerance=6):
    """Equal but for what a lossy codec does, which is most at the borders between the quarters."""
    assert photo.rgb.shape == rgb.shape
    off = np.abs(photo.rgb.astype(int) - rgb.astype(int)).max(axis=2)
    return np.percentile(off, 75) <= tolerance


LOSSLESS = [
    ("PNG", {}),
    ("WEBP", {"lossless": True}),
    ("TIFF", {}),
    ("TIFF", {"compression": "tiff_lzw"}),
    ("BMP", {}),
    ("PPM", {}),
    ("JPEG2000", {"irreversible": False}),
]


@pytest.mark.parametrize(("kind", "options"), LOSSLESS)
def test_lossless_formats_come_back_exactly(kind, options):
    assert (load_photo(encoded(Image.fromarray(picture()), kind, **options)).rgb == picture()).all()


def test_lossy_formats_come_back_nearly():
    image = Image.fromarray(picture(160, 96))
    for data in (encoded(image, "JPEG", quality=95), encoded(image, "WEBP", quality=95), heic(image)):
        assert near(load_photo(data), picture(160, 96))


def test_first_frame_of_an_animation():
    frames = [Image.fromarray(picture()), Image.fromarray(255 - picture())]
    for kind in ("GIF", "WEBP", "PNG", "TIFF"):
        options = {} if kind in ("GIF", "TIFF") else {"lossless": True}
        data = encoded(frames[0], kind, save_all=True, append_images=frames[1:], **options)
        assert near(load_photo(data), picture())


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("kind", ["JPEG", "PNG", "WEBP", "TIFF", "image"])
def test_every_exif_orientation_gives_the_same_upright_picture(kind, orientation):
    upright = Image.fromarray(picture(160, 96))
    undo = {2: 0, 3: 3, 4: 1, 5: 5, 6: 2, 7: 6, 8: 4}
    # Pillow's own transposition, by its number, is the reference: what a camera held that way has stored.
    stored = upright.transpose(Image.Transpose(undo[orientation])) if orientation > 1 else upright
    exif = Image.Exif()
    exif[0x0112] = orientation
    options = {"quality": 95} if kind == "JPEG" else {"lossless": True} if kind == "WEBP" else {}
    data = encoded(stored, "PNG" if kind == "image" else kind, exif=exif, **options)
    assert near(load_photo(Image.open(io.BytesIO(data)) if kind == "image" else data), picture(160, 96))


@pytest.mark.parametrize("orientation", [0, 9, 65535])
def test_an_orientation_that_does_not_exist_is_none(orientation):
    exif = Image.Exif()
    exif[0x0112] = orientation
    assert (load_photo(encoded(Image.fromarray(picture()), "PNG", exif=exif)).rgb == picture()).all()


def test_broken_exif_does_not_matter():
    data = encoded(Image.fromarray(picture()), "JPEG", exif=b"Exif\0\0MM\0*\xff\xff\xff\xff garbage", quality=95)
    assert near(load_photo(data), picture())


GREY = np.linspace(0, 255, 40 * 24).reshape(24, 40).astype(np.uint8)


@pytest.mark.parametrize(
    "image",
    [
        Image.fromarray(GREY),
        Image.fromarray(GREY).convert("P"),
        Image.fromarray(GREY).convert("LA"),
        Image.fromarray(GREY).convert("LA").convert("La"),
        Image.fromarray(GREY).convert("RGBA"),
        Image.fromarray(GREY).convert("RGBA").convert("RGBa"),
        Image.fromarray(GREY.astype(np.uint16) * 257),
        Image.fromarray(GREY.astype(np.int32) * 257),
    ],
    ids=lambda image: image.mode,
)
def test_every_mode_of_a_grey_image_is_the_same_photo(image):
    expected = np.repeat(GREY[..., None], 3, axis=2)
    assert (load_photo(image).rgb == expected).all()
    if image.mode not in ("La", "RGBa"):
        data = encoded(image, "TIFF" if image.mode in ("I", "PA") else "PNG")
        assert (load_photo(data).rgb == expected).all()


def test_colour_modes():
    image = Image.fromarray(picture())
    for mode in ("YCbCr", "HSV", "LAB", "CMYK"):
        assert near(load_photo(_as_mode(image, mode)), picture(), 10), mode
    assert near(load_photo(encoded(image.convert("CMYK"), "JPEG", quality=95)), picture(), 10)
    assert near(load_photo(encoded(image.convert("CMYK"), "TIFF")), picture(), 2)
    assert near(load_photo(encoded(image.quantize(4), "PNG")), picture(), 2)


def _as_mode(image, mode):
    if mode != "LAB":
        return image.convert(mode)
    srgb, lab = ImageCms.createProfile("sRGB"), ImageCms.createProfile("LAB")
    return ImageCms.profileToProfile(image, srgb, lab, outputMode="LAB")


def test_one_bit():
    image = Image.fromarray(GREY > 99)
    assert image.mode == "1"
    for photo in (load_photo(image), load_photo(encoded(image, "PNG")), load_photo(encoded(image, "TIFF"))):
        assert (photo.rgb == np.where(GREY > 99, 255, 0)[..., None]).all()


def test_sixteen_bit_colour_png():
    rgb = picture()
    rows = b"".join(b"\0" + (row.astype(">u2") * 257).tobytes() for row in rgb)
    assert (load_photo(png(40, 24, rows, depth=16, colour=2)).rgb == rgb).all()


def test_transparency_is_laid_on_white():
    rgba = np.dstack([picture(), np.full((24, 40), 255, np.uint8)])
    rgba[:12, :, 3] = 0
    rgba[12:, :20, 3] = 128
    expected = picture()
    expected[:12] = 255
    expected[12:, :20] = np.rint(expected[12:, :20] * (128 / 255) + 255 * (127 / 255))
    image = Image.fromarray(rgba)
    for source in (image, rgba, encoded(image, "PNG"), encoded(image, "WEBP", lossless=True), encoded(image, "TIFF")):
        assert np.abs(load_photo(source).rgb.astype(int) - expected).max() <= 1


def test_transparent_colours_of_palette_grey_and_rgb_png_are_white():
    image = Image.fromarray(picture()).quantize(4)
    clear = image.getpixel((0, 0))
    expected = picture()
    expected[:12, :20] = 255
    assert near(load_photo(encoded(image, "PNG", transparency=clear)), expected, 2)
    assert near(load_photo(encoded(image, "GIF", transparency=clear)), expected, 2)
    red = tuple(int(v) for v in picture()[0, 0])
    assert near(load_photo(encoded(Image.fromarray(picture()), "PNG", transparency=red)), expected, 0)


def test_an_embedded_profile_is_converted_to_srgb():
    """A linear profile: 128 of it is sRGB's 188 (IEC 61966-2-1)."""
    flat = Image.new("L", (8, 8), 128).convert("RGB")
    profile = _linear_profile()
    assert np.abs(load_photo(encoded(flat, "PNG", icc_profile=profile)).rgb.astype(int) - 188).max() <= 2
    srgb = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    assert (load_photo(encoded(flat, "PNG", icc_profile=srgb)).rgb == 128).all()


def _linear_profile():
    """sRGB's own profile with its tone curve replaced by gamma 1."""
    data = bytearray(ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes())
    for i in range(int.from_bytes(data[128:132], "big")):
        tag, start, size = struct.unpack_from(">4sII", data, 132 + 12 * i)
        if tag in (b"rTRC", b"gTRC", b"bTRC"):
            data[start : start + size] = (b"curv" + bytes(8)).ljust(size, b"\0")
        if tag == b"desc":
            data[start : start + size] = data[start : start + size].replace(b"\0R\0G\0B", b"\0L\0i\0n")
    return bytes(data)


@pytest.mark.parametrize("profile", [b"nonsense", bytes(200)])
@pytest.mark.parametrize("mode", ["RGB", "L", "CMYK"])
def test_a_broken_profile_is_ignored(mode, profile):
    image = Image.fromarray(picture()).convert(mode)
    data = encoded(image, "TIFF", icc_profile=profile)
    assert (load_photo(data).rgb == np.asarray(image.convert("RGB"))).all()


def test_a_profile_for_other_channels_is_ignored():
    srgb = _linear_profile()
    data = encoded(Image.fromarray(GREY), "PNG", icc_profile=srgb)
    assert (load_photo(data).rgb == GREY[..., None]).all()


@pytest.mark.parametrize("channels", [(), (3,), (4,)])
@pytest.mark.parametrize("dtype", ["uint8", "uint16", ">u2", "float16", "float32", "float64"])
def test_arrays_of_every_type_are_the_same_photo(dtype, channels):
    values = np.arange(24 * 40 * int(np.prod(channels, dtype=int))).reshape(24, 40, *channels) % 256
    if channels == (4,):
        values[..., 3] = 255
    scale = {"u": 257 if dtype != "uint8" else 1, "f": 1 / 255}[np.dtype(dtype).kind]
    rgb = np.broadcast_to(values[..., None] if channels == () else values[..., :3], (24, 40, 3))
    assert (load_photo((values * scale).astype(dtype)).rgb == rgb).all()


def test_an_array_need_not_be_contiguous():
    assert (load_photo(picture()[::-1, ::-2]).rgb == picture()[::-1, ::-2]).all()


@pytest.mark.parametrize(
    "array",
    [
        np.zeros((4, 4), np.int64),
        np.zeros((4, 4), bool),
        np.zeros((4, 4), complex),
        np.array([["a"]]),
        np.zeros(4, np.uint8),
        np.zeros((4, 4, 2), np.uint8),
        np.zeros((4, 4, 5), np.uint8),
        np.zeros((2, 4, 4, 3), np.uint8),
        np.zeros((0, 4, 3), np.uint8),
        np.zeros((4, 0), np.float64),
        np.full((4, 4), 1.5),
        np.full((4, 4), -0.1),
        np.full((4, 4), np.nan),
    ],
    ids=lambda a: f"{a.shape}{a.dtype}",
)
def test_arrays_that_are_no_picture(array):
    with pytest.raises(BadInput, match="photo: expected"):
        load_photo(array)


def test_from_every_kind_of_source(tmp_path, monkeypatch):
    data = encoded(Image.fromarray(picture()), "PNG")
    path = tmp_path / "me.png"
    path.write_bytes(data)
    for source in (path, str(path), data, bytearray(data), memoryview(data), io.BytesIO(data)):
        assert (load_photo(source).rgb == picture()).all()
    with path.open("rb") as file:
        assert (load_photo(file).rgb == picture()).all()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
    assert (load_photo("-").rgb == picture()).all()


@pytest.mark.parametrize("source", [None, 3, 1.5, [1, 2], {"a": 1}, object()])
def test_what_is_no_source(source):
    with pytest.raises(BadInput, match="expected a path"):
        load_photo(source)


def test_files_that_cannot_be_read_name_the_file(tmp_path, monkeypatch):
    (tmp_path / "empty.jpg").write_bytes(b"")
    (tmp_path / "notes.jpg").write_text("hello, I am no picture\n" * 20)
    (tmp_path / "page.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    for name, words in [
        ("empty.jpg", "empty"),
        ("notes.jpg", "expected JPEG, PNG"),
        ("page.svg", "expected JPEG, PNG"),
        ("missing.jpg", "No such file"),
        ("", "directory"),
    ]:
        with pytest.raises(BadInput, match=words) as error:
            load_photo(tmp_path / name)
        assert name in str(error.value)
        assert "\n" not in str(error.value)
    with pytest.raises(BadInput, match="null byte"):
        load_photo("a\0b")
    with (tmp_path / "notes.jpg").open() as file, pytest.raises(BadInput, match="open as text"):
        load_photo(file)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"")))
    with pytest.raises(BadInput, match="standard input: is empty"):
        load_photo("-")


def test_a_file_without_permission(tmp_path, monkeypatch):
    def refuse(path, mode):
        raise PermissionError(13, "Permission denied", path)

    monkeypatch.setattr("limner.storage.files.open", refuse, raising=False)
    with pytest.raises(BadInput, match=r"secret\.jpg.*Permission denied"):
        load_photo(tmp_path / "secret.jpg")


def test_a_heic_without_its_package_says_what_to_install(monkeypatch):
    data = heic(Image.fromarray(picture(64, 64)))
    monkeypatch.setitem(sys.modules, "pillow_heif", None)
    with pytest.raises(MissingExtra, match=r"HEIC.*limner\[heic\]"):
        load_photo(data)


def test_float_pixels_and_whole_numbers_beyond_sixteen_bits_are_refused():
    for image in (Image.fromarray(GREY.astype(np.float32)), Image.fromarray(GREY.astype(np.int32) * 100_000)):
        with pytest.raises(BadInput, match="8 or 16 bits"):
            load_photo(encoded(image, "TIFF"))


FILES = {
    kind: encoded(Image.fromarray(np.random.default_rng(2).integers(0, 255, (48, 64, 3), np.uint8)), kind, **options)
    for kind, options in [
        ("JPEG", {}),
        ("PNG", {}),
        ("WEBP", {}),
        ("TIFF", {"compression": "tiff_lzw"}),
        ("GIF", {}),
        ("BMP", {}),
        ("JPEG2000", {}),
    ]
}
FILES["progressive"] = encoded(Image.open(io.BytesIO(FILES["JPEG"])), "JPEG", progressive=True)


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(sorted(FILES)), st.floats(0, 1))
def test_a_file_cut_anywhere_gives_a_photo_or_one_clear_line(kind, part):
    data = FILES[kind]
    _photo_or_bad_input(data[: int(part * len(data))])


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(sorted(FILES)), st.lists(st.tuples(st.floats(0, 1), st.integers(0, 255)), max_size=20))
def test_a_file_with_wrong_bytes_gives_a_photo_or_one_clear_line(kind, changes):
    data = bytearray(FILES[kind])
    for where, value in changes:
        data[int(where * (len(data) - 1))] = value
    _photo_or_bad_input(bytes(data))


@given(st.binary(max_size=200))
def test_any_bytes_give_a_photo_or_one_clear_line(data):
    _photo_or_bad_input(data)


@pytest.mark.parametrize("part", np.linspace(0.02, 0.98, 25))
def test_a_heic_cut_anywhere(part):
    data = heic(Image.fromarray(picture(64, 64)))
    _photo_or_bad_input(data[: int(part * len(data))])


def _photo_or_bad_input(data):
    try:
        photo = load_photo(data)
    except BadInput as error:
        message = str(error)
    else:
        assert isinstance(photo, Photo)
        return
    assert message.startswith("photo: ")
    assert "\n" not in message


def test_half_a_jpeg_is_refused():
    with pytest.raises(BadInput, match="broken or cut short"):
        load_photo(FILES["JPEG"][: len(FILES["JPEG"]) // 2])


def test_warnings_of_pillow_stay_inside():
    data = FILES["TIFF"][:-200]
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        _photo_or_bad_input(data)
    assert not seen


def png(width, height, rows, depth=8, colour=0):
    """A PNG written by hand (ISO/IEC 15948)."""

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    parts = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + parts


def test_a_bomb_is_refused_before_it_is_decoded():
    for width, height in [(60_000, 60_000), (2**31 - 1, 2**31 - 1), (251, 1_000_000)]:
        with pytest.raises(BadInput, match=f"{width} x {height} px is .* megapixels, more than the 250"):
            load_photo(png(width, height, b""))
    assert Image.MAX_IMAGE_PIXELS is not None


def test_what_is_under_the_limit_is_scaled_down():
    photo = load_photo(png(8_000, 5_200, bytes(1 + 1_000) * 5_200, depth=1))
    assert photo.size_px == (4_000, 2_600)
    assert not photo.rgb.any()


def test_a_jpeg_of_41_megapixels_comes_back_smaller():
    image = Image.fromarray(picture(80, 52)).resize((8_000, 5_200), Image.Resampling.NEAREST)
    photo = load_photo(encoded(image, "JPEG", quality=30))
    width, height = photo.size_px
    assert (width, height) == (4_000, 2_600)
    assert near(Photo(photo.rgb[::50, ::50]), picture(80, 52))


@pytest.mark.parametrize("limit", [960, 959, 240, 60, 1])
@pytest.mark.parametrize("as_array", [True, False])
def test_however_low_the_limit_the_picture_keeps_it(monkeypatch, limit, as_array):
    monkeypatch.setattr(pixels, "MAX_PIXELS", limit)
    monkeypatch.setattr(pixels, "_BAND_PIXELS", 50)
    photo = load_photo(picture() if as_array else encoded(Image.fromarray(picture()), "PNG"))
    assert photo.rgb.shape[0] * photo.rgb.shape[1] <= limit
    assert np.abs(photo.rgb.mean((0, 1)) - picture().mean((0, 1))).max() < 8


def test_no_limit_is_above_what_a_face_needs():
    assert MAX_PIXELS == 40_000_000


@given(st.integers(0, 39), st.integers(0, 23), st.data())
def test_a_crop_is_that_part(x, y, data):
    w, h = data.draw(st.integers(1, 40 - x)), data.draw(st.integers(1, 24 - y))
    assert (crop_photo(Photo(picture()), (x, y, w, h)).rgb == picture()[y : y + h, x : x + w]).all()


@pytest.mark.parametrize(
    "box", [(-1, 0, 5, 5), (0, 0, 0, 5), (0, 0, 41, 5), (30, 0, 11, 5), (0, 20, 1, 5), (9**30, 0, 1, 1)]
)
def test_a_crop_outside_names_the_limits(box):
    with pytest.raises(BadInput, match=r"up to 40.*up to 24"):
        crop_photo(Photo(picture()), box)


@pytest.mark.parametrize(
    "box", [(), (1, 2, 3), (1, 2, 3, 4, 5), (0.5, 0, 5, 5), "1234", ("a",) * 4, (np.nan,) * 4, None]
)
def test_a_crop_that_is_no_box(box):
    with pytest.raises(BadInput, match="four whole numbers"):
        crop_photo(Photo(picture()), box)


@pytest.mark.skipif(sys.platform == "win32", reason="there no library is asked for what it needs itself")
def test_a_broken_tiff_says_nothing_in_the_terminal_but_our_line(capfd):
    whole = encoded(Image.fromarray(picture()), "TIFF", compression="tiff_lzw")
    broken = whole[:8] + b"\xff" * 64 + whole[72:]
    with pytest.raises(BadInput, match="broken or cut short"):
        load_photo(broken)
    assert capfd.readouterr() == ("", "")
    # Others hear libtiff as before, which shows too that there was something to be heard.
    with pytest.raises(OSError), Image.open(io.BytesIO(broken)) as image:  # noqa: PT011 - whatever it says
        image.load()
    assert ".tif: " in capfd.readouterr().err
