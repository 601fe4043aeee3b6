"""Several cameras, one ground: each object once, its places weighted by how well each camera knows them."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.stats import chi2

from contracts import FloatArray, GroundTracks, InputError

FUSED = "fused"
_EXACT_M = 1e-7
_CONTRADICTION = float(chi2.isf(1e-6, df=2))  # squared Mahalanobis distance that chance does not make
_Key = tuple[str, int]  # camera, track id


@dataclass(frozen=True, eq=False)
class _View:
    """One camera's row."""

    key: _Key
    label: str
    position_m: FloatArray
    cov_m2: FloatArray


@dataclass(frozen=True, eq=False)
class _Past:
    """Where an object was, (2,), and how fast, (2,), if it was seen in the moment before too."""

    time_ns: int
    position_m: FloatArray
    velocity_mps: FloatArray | None

    @classmethod
    def after(cls, before: "_Past | None", time_ns: int, position_m: FloatArray) -> "_Past":
        if before is None or time_ns <= before.time_ns:
            return cls(time_ns, position_m, None)
        return cls(time_ns, position_m, (position_m - before.position_m) / ((time_ns - before.time_ns) * 1e-9))

    def expected_m(self, time_ns: int) -> FloatArray | None:
        """(2,) where it would be with that velocity."""
        if self.velocity_mps is None:
            return None
        return np.asarray(self.position_m + self.velocity_mps * ((time_ns - self.time_ns) * 1e-9))


class CovarianceFuser:
    """Merges the cameras' views of a moment; implements ``contracts.Fuser``.

    Two rows are one object if they come from different cameras, bear the same label and lie within ``gate_m`` of each
    other or agree within their covariances (Mahalanobis distance below the ``gate_probability`` quantile of
    chi-square). Of conflicting pairs the nearest come first, so that two objects with one label stay two.

    The fused place is the mean weighted by information (inverse covariance), the fused covariance the inverse of the
    summed information: the cameras were calibrated apart, so their errors are independent. Rows that contradict each
    other by more than chance allows are not averaged: one of them is wrong, whatever it says. Those count that agree
    with the one nearest to where the object would be by its motion, or, if that is not known, followed longest.

    Identity: a fused object keeps the smallest fused id that any of its camera tracks had before; a track never seen
    before brings a new id. Through the overlap of two cameras an id is so handed from one to the other. Where a label
    names one object only, as the colour of a rail vehicle does, the id lasts through a gap between two views as well.
    Within a moment ids are unique.

    one_per_label: whether no two objects bear the same label. Then of several claims to a label the one that a camera
        has followed longest holds: a place that has just been found and contradicts it is none.
    """

    def __init__(self, gate_m: float = 0.06, gate_probability: float = 0.999, *, one_per_label: bool = False) -> None:
        if not (gate_m >= 0 and 0 < gate_probability < 1):
            raise InputError(f"CovarianceFuser: gate_m = {gate_m} must be >= 0, {gate_probability = } within (0, 1)")
        self._gate_m = gate_m
        self._gate_squared = float(chi2.ppf(gate_probability, df=2))
        self._one_per_label = one_per_label
        self._ids: dict[_Key, int] = {}
        self._ids_of_labels: dict[str, int] = {}
        self._followed: dict[_Key, int] = {}  # for how many moments in a row
        self._past: dict[int, _Past] = {}

    def reset(self) -> None:
        """Forget all identities."""
        self._ids.clear()
        self._ids_of_labels.clear()
        self._followed.clear()
        self._past.clear()

    def fuse(self, views: Sequence[GroundTracks]) -> GroundTracks:
        """All objects with a valid place, in the order of their ids.

        views: of one moment, at most one per camera, in any order. Rows that are not valid have no place and are left
        out.
        Raises InputError for views of different moments or two of the same camera.
        """
        time_ns = _common_time_ns(views)
        rows = [row for view in views for row in _rows(view)]
        self._followed = {row.key: self._followed.get(row.key, 0) + 1 for row in rows}
        groups = self._grouped(rows)
        if self._one_per_label:
            groups = self._undisputed(groups)
        ids = self._identify(groups)
        order = np.argsort(ids)
        merged = [_merge(self._consistent(groups[k], ids[k], time_ns)) for k in order]
        self._past = {
            ids[k]: _Past.after(self._past.get(ids[k]), time_ns, position)
            for k, (position, _) in zip(order.tolist(), merged, strict=True)
        }
        return GroundTracks(
            source=FUSED,
            time_ns=time_ns,
            ids=np.array(ids, dtype=np.int64)[order],
            labels=tuple(groups[k][0].label for k in order),
            positions_m=np.array([position for position, _ in merged]),
            covs_m2=np.array([cov for _, cov in merged]),
            valid=np.ones(len(groups), dtype=np.bool_),
        )

    def _grouped(self, rows: list[_View]) -> list[list[_View]]:
        """Rows by object: pairs joined from the nearest on, never two rows of one camera in a group."""
        rows = sorted(rows, key=lambda row: row.key)
        group_of = {row.key: [row] for row in rows}
        for one, other in self._pairs(rows):
            left, right = group_of[one.key], group_of[other.key]
            if not {row.key[0] for row in left} & {row.key[0] for row in right}:
                left.extend(right)
                group_of.update({row.key: left for row in right})
        unique = {id(group): sorted(group, key=lambda row: row.key) for group in group_of.values()}
        return sorted(unique.values(), key=lambda group: group[0].key)

    def _undisputed(self, groups: list[list[_View]]) -> list[list[_View]]:
        """Of the groups with one label that which was followed longest, the first of them if there are several."""
        held: dict[str, list[_View]] = {}
        for group in sorted(groups, key=lambda group: -max(self._followed[row.key] for row in group)):
            held.setdefault(group[0].label, group)
        return [group for group in groups if held[group[0].label] is group]

    def _pairs(self, rows: list[_View]) -> list[tuple[_View, _View]]:
        """Pairs that may be one object, the nearest first."""
        found = []
        for number, one in enumerate(rows):
            for other in rows[number + 1 :]:
                if one.key[0] == other.key[0] or one.label != other.label:
                    continue
                apart = one.position_m - other.position_m
                distance = float(np.hypot(*apart))
                agree = float(apart @ _information(one.cov_m2 + other.cov_m2) @ apart) <= self._gate_squared
                if distance <= self._gate_m or agree:
                    found.append((distance, one, other))
        return [(one, other) for _, one, other in sorted(found, key=lambda pair: (pair[0], pair[1].key, pair[2].key))]

    def _consistent(self, group: list[_View], identity: int, time_ns: int) -> list[_View]:
        """The rows that do not contradict each other; see the class's description."""
        if all(_agree(one, other) for one, other in combinations(group, 2)):
            return group
        past = self._past.get(identity)
        expected_m = None if past is None else past.expected_m(time_ns)
        if expected_m is None:
            leading = max(group, key=lambda row: self._followed[row.key])
        else:
            leading = min(group, key=lambda row: float(np.linalg.norm(row.position_m - expected_m)))
        return [row for row in group if row is leading or _agree(row, leading)]

    def _identify(self, groups: list[list[_View]]) -> list[int]:
        """One id per group, by the rule in the class's description."""
        known = [min((self._ids[row.key] for row in group if row.key in self._ids), default=None) for group in groups]
        labels = [group[0].label for group in groups]
        if self._one_per_label:
            present = set(known)  # what a camera still follows goes before what only looks the same
            again = [self._ids_of_labels.get(label) for label in labels]
            known = [
                before if before is not None or identity in present else identity
                for before, identity in zip(known, again, strict=True)
            ]
        taken: set[int] = set()
        ids = []
        fresh = max(self._ids.values(), default=-1) + 1
        for before in known:
            if before is None or before in taken:
                identity, fresh = fresh, fresh + 1
            else:
                identity = before
            taken.add(identity)
            ids.append(identity)
        self._ids_of_labels = dict(zip(labels, ids, strict=True)) | self._ids_of_labels  # the first one stays
        self._ids.update({row.key: identity for group, identity in zip(groups, ids, strict=True) for row in group})
        return ids


def _common_time_ns(views: Sequence[GroundTracks]) -> int:
    if not views:
        raise InputError("no views were given to fuse; an empty view of one camera is enough")
    sources = [view.source for view in views]
    if len(set(sources)) < len(sources):
        raise InputError(f"a camera occurs twice among the views to fuse: {sorted(sources)}")
    times = {view.time_ns for view in views}
    if len(times) > 1:
        raise InputError(f"the views to fuse are of different moments: time_ns = {sorted(times)}")
    return times.pop()


def _rows(view: GroundTracks) -> list[_View]:
    return [
        _View((view.source, int(view.ids[row])), view.labels[row], view.positions_m[row], view.covs_m2[row])
        for row in np.flatnonzero(view.valid)
    ]


def _agree(one: _View, other: _View) -> bool:
    apart = one.position_m - other.position_m
    return float(apart @ _information(one.cov_m2 + other.cov_m2) @ apart) <= _CONTRADICTION


def _information(cov_m2: FloatArray) -> FloatArray:
    """Inverse covariance; a place known exactly, as an oracle's is, counts as known to a tenth of a micrometre."""
    return np.linalg.inv(cov_m2 + _EXACT_M**2 * np.eye(2)).astype(np.float64)


def _merge(group: list[_View]) -> tuple[FloatArray, FloatArray]:
    """Information-weighted mean and its covariance (Bar-Shalom et al. 2001, section 3.4, for independent errors)."""
    if len(group) == 1:
        return group[0].position_m, group[0].cov_m2
    information = [_information(row.cov_m2) for row in group]
    cov = np.linalg.inv(np.sum(information, axis=0))
    weighted = np.sum([info @ row.position_m for info, row in zip(information, group, strict=True)], axis=0)
    return cov @ weighted, 0.5 * (cov + cov.T)
