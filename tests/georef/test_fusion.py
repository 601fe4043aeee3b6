import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts import Fuser, GroundTracks, InputError
from georef.fusion import CovarianceFuser


def view(source, objects, time_ns=0):
    """objects: (id, label, (x, y), cov or sigma) rows."""
    covs = [np.eye(2) * c**2 if np.isscalar(c) else c for *_, c in objects]
    return GroundTracks(
        source,
        time_ns,
        np.array([o[0] for o in objects], dtype=np.int64),
        tuple(o[1] for o in objects),
        np.array([o[2] for o in objects], dtype=float),
        np.array(covs, dtype=float),
        np.ones(len(objects), bool),
    )


@st.composite
def covariances(draw):
    a, b = draw(st.floats(1e-3, 3e-2)), draw(st.floats(1e-3, 3e-2))
    angle = draw(st.floats(0, np.pi))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return turn @ np.diag([a**2, b**2]) @ turn.T


@st.composite
def moments(draw):
    """One to three cameras that each see some of up to four objects, well apart or with one label twice."""
    objects = draw(st.lists(st.sampled_from(["blue", "red", "car"]), min_size=0, max_size=4))
    views = []
    for camera in draw(st.permutations(["west", "middle", "east"]))[: draw(st.integers(1, 3))]:
        rows = []
        for number, label in enumerate(objects):
            if draw(st.booleans()):
                place = (number + draw(st.floats(-0.01, 0.01)), draw(st.floats(-0.01, 0.01)))
                rows.append((10 + number, label, place, draw(covariances())))
        views.append(view(camera, rows))
    return views


def rows_of(fused):
    return sorted(
        zip(fused.ids.tolist(), fused.labels, fused.positions_m.tolist(), fused.covs_m2.tolist(), strict=True)
    )


@given(moments(), st.randoms(use_true_random=False))
def test_the_order_of_the_views_does_not_matter(views, random):
    shuffled = list(views)
    random.shuffle(shuffled)
    assert rows_of(CovarianceFuser().fuse(views)) == rows_of(CovarianceFuser().fuse(shuffled))


@given(moments())
def test_one_view_passes_through(views):
    fused = CovarianceFuser().fuse(views[:1])
    assert fused.source == "fused"
    assert fused.labels == views[0].labels
    assert np.array_equal(fused.positions_m, views[0].positions_m)
    assert np.array_equal(fused.covs_m2, views[0].covs_m2)


@given(moments())
def test_every_object_is_counted_once(views):
    seen = {(number, label) for one in views for number, label in zip(one.ids.tolist(), one.labels, strict=True)}
    fused = CovarianceFuser().fuse(views)
    assert len(fused) == len(seen)
    assert len(set(fused.ids.tolist())) == len(fused)


@given(moments())
def test_a_fused_covariance_is_never_larger_than_that_of_any_view(views):
    fused = CovarianceFuser().fuse(views)
    for one in views:
        for position, cov in zip(one.positions_m, one.covs_m2, strict=True):
            nearest = np.hypot(*(fused.positions_m - position).T).argmin()
            assert np.linalg.eigvalsh(cov - fused.covs_m2[nearest]).min() > -1e-12


def test_the_mean_is_weighted_by_information():
    fused = CovarianceFuser().fuse(
        [view("west", [(1, "blue", (0.0, 0.0), 0.001)]), view("east", [(7, "blue", (0.010, 0.0), 0.003)])]
    )
    assert np.abs(fused.positions_m - [[0.001, 0.0]]).max() < 1e-9
    assert np.abs(fused.covs_m2[0] - np.eye(2) * 0.9e-6).max() < 1e-13


def test_two_objects_with_one_label_stay_two():
    west = view("west", [(1, "car", (0.00, 0.0), 0.02), (2, "car", (0.05, 0.0), 0.02)])
    east = view("east", [(1, "car", (0.051, 0.0), 0.02), (2, "car", (0.001, 0.0), 0.02)])
    fused = CovarianceFuser().fuse([west, east])
    assert np.abs(np.sort(fused.positions_m[:, 0]) - [0.0005, 0.0505]).max() < 1e-12


def test_places_known_exactly_are_merged_only_where_they_agree():
    west = view("west", [(1, "car", (0.0, 0.0), 0.0), (2, "car", (1.0, 0.0), 0.0)])
    east = view("east", [(1, "car", (1.0, 0.0), 0.0), (2, "car", (2.0, 0.0), 0.0)])
    fused = CovarianceFuser().fuse([west, east])
    assert np.abs(np.sort(fused.positions_m[:, 0]) - [0.0, 1.0, 2.0]).max() < 1e-12
    assert fused.covs_m2.max() < 1e-12


def test_different_labels_are_different_objects():
    fused = CovarianceFuser().fuse(
        [view("west", [(1, "blue", (0, 0), 0.01)]), view("east", [(1, "red", (0, 0), 0.01)])]
    )
    assert sorted(fused.labels) == ["blue", "red"]


def test_an_identity_is_handed_over_through_the_overlap():
    fuser = CovarianceFuser()
    first = fuser.fuse([view("west", [(5, "blue", (0.0, 0), 0.002)]), view("east", [])])
    both = fuser.fuse([view("west", [(5, "blue", (0.5, 0), 0.002)]), view("east", [(9, "blue", (0.501, 0), 0.002)])])
    last = fuser.fuse([view("west", []), view("east", [(9, "blue", (1.0, 0), 0.002)])])
    assert first.ids.tolist() == both.ids.tolist() == last.ids.tolist()


def test_two_objects_never_share_an_identity():
    fuser = CovarianceFuser()
    fuser.fuse([view("west", [(1, "car", (0, 0), 0.002)]), view("east", [(1, "car", (0, 0), 0.002)])])
    parted = fuser.fuse([view("west", [(1, "car", (0, 0), 0.002)]), view("east", [(1, "car", (3, 0), 0.002)])])
    assert len(set(parted.ids.tolist())) == 2


def test_reset_starts_identities_again():
    fuser = CovarianceFuser()
    fuser.fuse([view("west", [(1, "car", (0, 0), 0.002)])])
    fuser.reset()
    assert fuser.fuse([view("west", [(4, "car", (9, 0), 0.002)])]).ids.tolist() == [0]


def test_rows_without_a_place_are_left_out():
    nowhere = GroundTracks("west", 0, [3], ("blue",), [[np.nan] * 2], [np.full((2, 2), np.nan)], [False])
    assert isinstance(CovarianceFuser(), Fuser)
    assert len(CovarianceFuser().fuse([nowhere])) == 0


@pytest.mark.parametrize(
    ("views", "reason"),
    [
        ([], "no views"),
        ([view("west", []), view("west", [])], "twice"),
        ([view("west", []), view("east", [], time_ns=40)], "different moments"),
    ],
)
def test_views_that_do_not_belong_together_are_refused(views, reason):
    with pytest.raises(InputError, match=reason):
        CovarianceFuser().fuse(views)


def test_impossible_gates_are_refused():
    with pytest.raises(InputError, match="gate_m"):
        CovarianceFuser(gate_m=-1.0)


def test_where_a_label_names_one_object_its_identity_lasts_through_a_gap():
    fuser = CovarianceFuser(one_per_label=True)
    first = fuser.fuse([view("west", [(5, "blue", (0.0, 0), 0.002), (6, "red", (0.3, 0), 0.002)]), view("east", [])])
    fuser.fuse([view("west", []), view("east", [])])
    after = fuser.fuse([view("west", []), view("east", [(9, "red", (1.0, 0), 0.002), (4, "blue", (1.4, 0), 0.002)])])
    assert dict(zip(first.labels, first.ids.tolist(), strict=True)) == dict(
        zip(after.labels, after.ids.tolist(), strict=True)
    )


@given(st.integers(1, 6), st.integers(0, 5), st.booleans())
def test_of_two_claims_to_one_label_the_one_followed_longest_holds(longer, fewer, east_first):
    fuser = CovarianceFuser(one_per_label=True)
    long, short = ("east", "west") if east_first else ("west", "east")
    for moment in range(longer + fewer):
        held = [(1, "blue", (0.01 * moment, 0.0), 0.002)]
        new = [(2, "blue", (1.0, 0.0), 0.002)] if moment >= longer else []
        fused = fuser.fuse([view(long, held), view(short, new)])
        assert fused.ids.tolist() == [0]
        assert fused.positions_m[0, 0] == 0.01 * moment
    alone = fuser.fuse([view(long, []), view(short, [(2, "blue", (1.0, 0.0), 0.002)])])
    assert alone.ids.tolist() == [0]


def test_where_a_label_may_name_many_a_gap_ends_an_identity():
    fuser = CovarianceFuser()
    first = fuser.fuse([view("west", [(5, "car", (0.0, 0), 0.002)]), view("east", [])])
    after = fuser.fuse([view("west", []), view("east", [(9, "car", (1.0, 0), 0.002)])])
    assert first.ids.tolist() != after.ids.tolist()


def moving_blue(west_errors_m, east_errors_m, sigma_m=3e-4):
    """Two cameras over one vehicle at 0.4 m/s; an error per moment, None where a camera does not see it."""
    for k, errors in enumerate(zip(west_errors_m, east_errors_m, strict=True)):
        yield [
            view(name, [] if error is None else [(7, "blue", (0.016 * k + error, 0.0), sigma_m)], 40_000_000 * k)
            for name, error in zip(("west", "east"), errors, strict=True)
        ]


@pytest.mark.parametrize("wrong", ["west", "east"])
def test_of_two_places_that_contradict_the_one_counts_where_the_motion_leads(wrong):
    off, true = [0.0, 0.0, 0.0, 0.05], [0.0] * 4
    fuser = CovarianceFuser(one_per_label=True)
    fused = [fuser.fuse(views) for views in moving_blue(*((off, true) if wrong == "west" else (true, off)))]
    assert np.abs(fused[-1].positions_m - [[0.048, 0.0]]).max() < 1e-12
    assert np.abs(fused[-1].covs_m2 - 9e-8 * np.eye(2)).max() < 1e-12  # of one camera alone
    assert np.abs(fused[-2].covs_m2 - 4.5e-8 * np.eye(2)).max() < 1e-12


def test_of_two_places_that_contradict_the_one_followed_longest_counts_where_no_motion_is_known():
    fuser = CovarianceFuser(one_per_label=True)
    fused = [fuser.fuse(views) for views in moving_blue([0.0, 0.0], [None, 0.05])]
    assert np.abs(fused[-1].positions_m - [[0.016, 0.0]]).max() < 1e-12


def test_places_that_differ_by_chance_are_averaged():
    fuser = CovarianceFuser(one_per_label=True)
    fused = [fuser.fuse(views) for views in moving_blue([0.0, 0.0, 6e-4], [0.0, 0.0, -6e-4])]
    assert np.abs(fused[-1].positions_m - [[0.032, 0.0]]).max() < 1e-12
