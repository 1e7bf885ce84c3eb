import numpy as np
import pytest

from limner.errors import BadInput
from limner.types import Photo
from limner.vision.edges.canny import CannySettings, canny_edges, thresholds
from limner.vision.scale import ScaleSettings, to_working_scale
from portraits import astronaut, plain_face

SETTINGS = CannySettings()
FACE = plain_face()


@pytest.fixture(scope="module")
def working():
    return to_working_scale(*astronaut(), ScaleSettings())


def grey(values):
    return Photo(np.repeat(np.asarray(values, np.uint8)[..., None], 3, axis=2))


def test_a_step_is_one_edge_along_it():
    picture = np.zeros((200, 300))
    picture[:, 140:] = 200
    edges = canny_edges(grey(picture), FACE, SETTINGS.replace(high=0.05))
    rows, columns = np.nonzero(edges.mask)
    assert set(columns) <= {139, 140}
    assert len(set(columns)) == 1
    assert len(rows) >= 196
    np.testing.assert_allclose(edges.angle_rad[edges.mask], np.pi / 2, atol=1e-3)
    assert edges.strength[edges.mask].min() > 0.9


def test_a_disc_is_one_ring_at_its_border():
    y, x = np.mgrid[:240, :240]
    away = np.hypot(x - 120, y - 118)
    edges = canny_edges(grey(np.where(away < 60, 30, 220)), FACE, SETTINGS.replace(high=0.05))
    assert np.abs(away[edges.mask] - 60).max() <= 1.5
    radial = np.arctan2(y - 118, x - 120)[edges.mask]
    assert np.abs(np.cos(edges.angle_rad[edges.mask] - radial)).max() < 0.2


def test_automatic_thresholds_are_the_documented_ones():
    magnitude = np.random.default_rng(0).random((100, 100)).astype(np.float32)
    low, high = thresholds(magnitude, SETTINGS)
    assert high == pytest.approx(2.5 * 0.7, rel=0.02)
    assert low == pytest.approx(0.6 * high)
    assert (magnitude < high / 2.5).mean() == pytest.approx(0.7, abs=0.001)


def test_thresholds_by_hand():
    magnitude = np.ones((4, 4), np.float32)
    assert thresholds(magnitude, SETTINGS.replace(high=0.3)) == pytest.approx((0.18, 0.3))
    assert thresholds(magnitude, SETTINGS.replace(high=0.3, low=0.1)) == pytest.approx((0.1, 0.3))
    assert thresholds(magnitude, SETTINGS.replace(high=0.1, low=0.3)) == pytest.approx((0.1, 0.1))


def test_higher_thresholds_by_hand_give_a_part_of_the_edges(working):
    before = None
    for high in (0.01, 0.02, 0.04, 0.08, 0.16, 0.32):
        mask = canny_edges(working.photo, working.face, SETTINGS.replace(high=high, low=high / 2)).mask
        assert before is None or (before | ~mask).all()
        before = mask
    for low in (0.02, 0.03, 0.05):
        mask = canny_edges(working.photo, working.face, SETTINGS.replace(high=0.05, low=low)).mask
        assert low == 0.02 or (before | ~mask).all()
        before = mask


def test_a_busy_wall_does_not_change_the_face(working):
    """Only the face's own pixels set the thresholds."""
    plain = canny_edges(working.photo, working.face, SETTINGS).mask
    rgb = working.photo.rgb.copy()
    rgb[:60] = np.random.default_rng(0).integers(0, 256, rgb[:60].shape)
    busy = canny_edges(Photo(rgb), working.face, SETTINGS).mask
    np.testing.assert_array_equal(plain[90:], busy[90:])


def test_more_blur_leaves_fewer_edges(working):
    counts = [
        canny_edges(working.photo, working.face, SETTINGS.replace(high=0.03, blur_px=sigma)).mask.sum()
        for sigma in (0, 1, 2, 4)
    ]
    assert counts == sorted(counts, reverse=True)


@pytest.mark.parametrize("size", [(1, 1), (1, 40), (40, 40), (200, 300)])
@pytest.mark.parametrize("value", [0, 128, 255])
def test_blank_and_tiny_photos_have_no_edge(size, value):
    edges = canny_edges(grey(np.full(size, value)), FACE, SETTINGS)
    assert edges.mask.shape == size
    assert not edges.mask.any()


@pytest.mark.parametrize("change", [{"blur_px": -1}, {"quantile": 1.0}, {"high": -0.1}, {"low_of_high": 1.5}])
def test_values_outside_their_limits_are_refused(change):
    with pytest.raises(BadInput):
        SETTINGS.replace(**change)


def test_the_same_photo_gives_the_same_edges(working):
    one, other = (canny_edges(working.photo, working.face, SETTINGS) for _ in range(2))
    assert one == other
