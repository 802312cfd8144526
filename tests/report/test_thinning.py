"""Curves with fewer points keep their peaks and their gaps."""

import numpy as np
from hypothesis import given, strategies as st

from symid.report.figures.envelope import envelope, envelope_places

curves = st.lists(st.floats(-1e6, 1e6) | st.just(float("nan")), min_size=1, max_size=200).map(np.array)


@given(curves, st.integers(2, 50))
def test_no_peak_is_lost(values, most):
    thin = envelope(values, most)
    assert thin.size <= most + 2
    if np.isfinite(values).any():
        assert np.nanmin(thin) == np.nanmin(values)
        assert np.nanmax(thin) == np.nanmax(values)
    else:
        assert np.isnan(thin).all()


@given(curves, st.integers(2, 50))
def test_every_point_has_a_place_and_places_increase(values, most):
    places = envelope_places(np.arange(float(values.size)), most)
    assert places.size == envelope(values, most).size
    assert (np.diff(places) >= 0).all()
    assert places[0] == 0


def test_a_point_stands_no_further_than_its_bundle_from_where_it_was():
    values = np.zeros(1000)
    values[[137, 642]] = 1.0, -1.0
    thin, places = envelope(values, 100), envelope_places(np.arange(1000.0), 100)
    assert abs(places[np.argmax(thin)] - 137) < 20
    assert abs(places[np.argmin(thin)] - 642) < 20


def test_short_curves_stay_as_they_are():
    values = np.array([3.0, 1.0, np.nan])
    assert envelope(values, 3) is values
