import numpy as np
import pytest

from limner.vision.edges.flow import averaged_along, edge_flow, sampled, slopes

Y, X = np.indices((161, 161), np.float32) - 80
AWAY, AROUND = np.hypot(X, Y), np.arctan2(Y, X)


def ring(radius=50.0, width=2.0, dark=-1.0):
    """A soft line around the middle."""
    return (dark * np.exp(-(((AWAY - radius) / width) ** 2) / 2)).astype(np.float32)


def off_tangent(flow):
    """Angle between the flow and the circles around the middle."""
    return np.abs(np.arcsin(np.clip(flow.x * np.cos(AROUND) + flow.y * np.sin(AROUND), -1, 1)))


@pytest.mark.parametrize("dark", [-1.0, 1.0])
@pytest.mark.parametrize("reach", [1.5, 2.5, 4.0])
def test_the_flow_of_a_ring_is_tangential(dark, reach):
    flow = edge_flow(ring(dark=dark), 0.0, reach)
    near = np.abs(AWAY - 50) < 6
    assert np.rad2deg(off_tangent(flow)[near].max()) < 3


def test_the_flow_is_of_unit_length_and_coherent_on_a_line():
    flow = edge_flow(ring(), 1.0, 2.5)
    np.testing.assert_allclose(np.hypot(flow.x, flow.y), 1, atol=1e-5)
    assert flow.coherence[np.abs(AWAY - 50) < 2].min() > 0.9
    assert flow.coherence.min() >= 0
    assert flow.coherence.max() <= 1


def test_noise_has_no_direction():
    rng = np.random.default_rng(0)
    flow = edge_flow(rng.normal(size=(200, 200)).astype(np.float32), 0.0, 12.0)
    assert np.median(flow.coherence) < 0.3


@pytest.mark.parametrize("gain", [0.01, 1.0, 100.0])
def test_the_flow_does_not_depend_on_light_and_contrast(gain):
    one, other = edge_flow(ring(), 1.0, 2.5), edge_flow(ring() * np.float32(gain) + 3, 1.0, 2.5)
    near = np.abs(AWAY - 50) < 4
    np.testing.assert_allclose((one.x * other.x + one.y * other.y)[near] ** 2, 1, atol=1e-3)


def test_slopes_are_those_of_a_plane():
    dx, dy = slopes((3 * X + 5 * Y).astype(np.float32))
    np.testing.assert_allclose(dx[1:-1, 1:-1], 3, rtol=1e-5)
    np.testing.assert_allclose(dy[1:-1, 1:-1], 5, rtol=1e-5)


def test_a_mean_along_the_flow_keeps_a_ring_and_takes_specks():
    rng = np.random.default_rng(1)
    clean = ring()
    noise = rng.normal(0, 0.3, clean.shape).astype(np.float32)
    flow = edge_flow(clean, 1.0, 2.5)
    crest = np.abs(AWAY - 50) < 1
    np.testing.assert_allclose(averaged_along(clean, flow, 6.0)[crest], clean[crest], atol=0.05)
    assert averaged_along(noise, flow, 6.0)[crest].std() < 0.5 * noise[crest].std()


def test_a_mean_along_the_flow_ignores_its_sign():
    flow = edge_flow(ring(), 1.0, 2.5)
    rng = np.random.default_rng(2)
    sign = rng.choice(np.float32([-1, 1]), flow.x.shape)
    turned = type(flow)(flow.x * sign, flow.y * sign, flow.coherence)
    picture = rng.normal(size=flow.x.shape).astype(np.float32)
    np.testing.assert_allclose(averaged_along(picture, turned, 5.0), averaged_along(picture, flow, 5.0), atol=1e-4)


def test_an_even_picture_has_an_even_mean():
    even = np.full((30, 40), 0.7, np.float32)
    flow = edge_flow(even, 1.0, 2.5)
    assert np.isfinite(flow.x).all()
    np.testing.assert_allclose(averaged_along(even, flow, 5.0), 0.7, rtol=1e-5)


def test_a_picture_is_read_between_its_pixels():
    picture = (2 * X + Y).astype(np.float32)
    x, y = np.float32([[80.5, 20.25]]), np.float32([[80.0, 33.5]])
    np.testing.assert_allclose(sampled(picture, x, y), 2 * (x - 80) + y - 80, atol=0.05)
