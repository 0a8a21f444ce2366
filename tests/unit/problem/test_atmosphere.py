"""The standard atmosphere, and airspeeds in it."""

import pytest

from pathgene.host.problem.atmosphere import air_density, equivalent_m_s, true_m_s


# Published values of the standard atmosphere.
@pytest.mark.parametrize(
    ("altitude_m", "density"),
    [
        (0, 1.2250),
        (1000, 1.1116),
        (5000, 0.73612),
        (11_000, 0.36392),
        (15_000, 0.19367),
        (20_000, 0.08803),
    ],
)
def test_standard_atmosphere(altitude_m, density):
    assert air_density(altitude_m) == pytest.approx(density, rel=1e-3)


def test_airspeeds_convert_by_the_root_of_the_density():
    assert true_m_s(20.0, 3000.0) == pytest.approx(20 * (1.2250 / 0.90925) ** 0.5, rel=1e-3)
    assert equivalent_m_s(true_m_s(20.0, 3000.0), 3000.0) == pytest.approx(20.0)
