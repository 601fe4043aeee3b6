"""Single motions whose outcome is known by hand."""

import numpy as np
import pytest
from motion_cases import FORK, footprints, happened, run, seconds, speeds, vehicle

from contracts import EventKind, InputError, SwitchState
from sim.boxes import separation_m
from sim.drivers import STANDOFF_M
from sim.motion_spec import MotionSpec, TimedEvent
from sim.rail_motion import RailMotion
from sim.rail_run import STEP_NS

STEP_S = STEP_NS * 1e-9


def test_a_vehicle_left_alone_holds_its_speed():
    truths = run(vehicle(offset_m=0.2, speed_mps=0.4), until_s=2.0)
    x = np.array([truth.positions_m[0, 0] for truth in truths])
    expected = -1.8 + 0.4 * np.array([truth.time_ns * 1e-9 for truth in truths])
    assert np.abs(x - expected).max() < 1e-9
    assert truths[-1].places[0].section == "stem"
    assert abs(truths[-1].places[0].offset_m - 1.0) < 1e-9


def test_a_balise_reports_at_the_moment_at_which_the_centre_passes_it():
    (event,) = happened(run(vehicle(offset_m=0.2, speed_mps=0.37), until_s=2.0), EventKind.BALISE)
    assert (event.subjects, event.detail) == (("red",), "0001")
    assert abs(seconds(event) - 0.3 / 0.37) < 2e-9


def test_a_balise_reports_its_moment_while_the_vehicle_accelerates():
    truths = run(
        vehicle(offset_m=0.3, speed_mps=0.0, acceleration_mps2=0.5),
        events=[TimedEvent(0.0, vehicle="red", speed_mps=1.0)],
        until_s=1.5,
    )
    (event,) = happened(truths, EventKind.BALISE)
    assert abs(seconds(event) - np.sqrt(2 * 0.2 / 0.5)) < 1e-8


def test_a_stop_takes_the_braking_distance():
    truths = run(
        vehicle(offset_m=0.3, speed_mps=0.5, braking_mps2=1.0, manner="blind"),
        events=[TimedEvent(0.5, vehicle="red", do="stop")],
        until_s=1.5,
    )
    way_m = truths[-1].positions_m[0, 0] - truths[0].positions_m[0, 0]
    assert abs(way_m - (0.25 + 0.5**2 / 2.0)) < 1e-9
    assert speeds(truths)[-1, 0] == 0.0


def test_reverse_goes_back_the_same_way_at_the_same_speed():
    truths = run(
        vehicle(offset_m=1.0, speed_mps=0.4), events=[TimedEvent(0.5, vehicle="red", do="reverse")], until_s=2.5
    )
    assert abs(truths[-1].velocities_mps[0, 0] + 0.4) < 1e-9
    assert abs(truths[-1].headings_rad[0]) < 1e-12  # it does not turn round
    assert truths[-1].places[0].direction == 1


def test_reverse_after_a_stop_leads_back():
    truths = run(
        vehicle(offset_m=1.0, speed_mps=0.4),
        events=[TimedEvent(0.2, vehicle="red", do="stop"), TimedEvent(1.0, vehicle="red", do="reverse")],
        until_s=2.5,
    )
    assert abs(truths[-1].velocities_mps[0, 0] + 0.4) < 1e-9


def test_head_on_vehicles_touch_when_the_air_between_them_is_used_up_and_stand_from_then_on():
    truths = run(
        vehicle(offset_m=0.5, speed_mps=0.4, manner="blind"),
        vehicle(offset_m=1.5, heading="backward", speed_mps=0.3, manner="blind", colour="blue"),
        until_s=2.0,
    )
    (event,) = happened(truths, EventKind.CONTACT)
    assert event.subjects == ("blue", "red")
    assert abs(seconds(event) - (1.0 - 0.12) / 0.7) < 1e-5
    assert speeds(truths)[-1].tolist() == [0.0, 0.0]
    assert abs(separation_m(*footprints(truths[-1]))) < 2e-6


def test_a_run_into_a_standing_vehicle_is_timed_between_frames():
    truths = run(
        vehicle(offset_m=0.5, speed_mps=0.5, manner="blind"),
        vehicle(offset_m=0.9, speed_mps=0.0, colour="blue"),
        until_s=1.0,
        step_s=0.5,
    )
    (event,) = happened(truths, EventKind.CONTACT)
    assert abs(seconds(event) - (0.4 - 0.12) / 0.5) < 1e-5


def test_after_a_contact_a_vehicle_can_back_off_but_not_press_on():
    events = [
        TimedEvent(1.5, vehicle="red", speed_mps=0.4),
        TimedEvent(2.0, vehicle="blue", do="reverse"),
        TimedEvent(2.5, vehicle="red", do="stop"),
    ]
    truths = run(
        vehicle(offset_m=0.7, speed_mps=0.4, manner="blind"),
        vehicle(offset_m=1.3, heading="backward", speed_mps=0.4, manner="blind", colour="blue"),
        events=events,
        until_s=3.0,
    )
    x = {truth.time_ns: truth.positions_m[:, 0] for truth in truths}
    assert len(happened(truths, EventKind.CONTACT)) == 1
    assert abs(x[2_000_000_000] - x[1_000_000_000]).max() < 1e-6  # red presses in vain
    assert x[3_000_000_000][1] - x[2_000_000_000][1] > 0.2  # blue leaves


def test_an_attentive_vehicle_follows_without_touching_and_stops_behind_a_standing_one():
    truths = run(
        vehicle(offset_m=0.3, speed_mps=0.5),
        vehicle(offset_m=0.8, speed_mps=0.2, colour="blue", manner="blind"),
        events=[TimedEvent(1.5, vehicle="blue", do="stop")],
        until_s=4.0,
    )
    gaps = [separation_m(*footprints(truth)) for truth in truths]
    assert not happened(truths, EventKind.CONTACT)
    assert min(gaps) > STANDOFF_M - 1e-3
    assert speeds(truths)[-1].max() < 1e-3
    assert gaps[-1] < STANDOFF_M + 5e-3


def test_attentive_vehicles_that_meet_head_on_both_stop():
    truths = run(vehicle(offset_m=0.5), vehicle(offset_m=1.5, heading="backward", colour="blue"), until_s=3.0)
    assert not happened(truths, EventKind.CONTACT)
    assert speeds(truths)[-1].max() < 1e-3


def test_an_attentive_vehicle_stops_before_the_buffer_and_a_blind_one_runs_into_it():
    wise = run(vehicle("main", 1.5), until_s=3.0)
    assert not happened(wise, EventKind.DERAIL)
    assert speeds(wise)[-1, 0] < 1e-3
    blind = run(vehicle("main", 1.5, manner="blind", speed_mps=0.5), until_s=3.0)
    (event,) = happened(blind, EventKind.DERAIL)
    assert event.subjects == ("red",)
    assert abs(seconds(event) - 0.44 / 0.5) < 1e-8  # its nose is 0.06 m ahead of its centre
    assert abs(blind[-1].positions_m[0, 0] - 1.94) < 1e-9


def test_a_derailed_vehicle_stands_for_good():
    truths = run(
        vehicle("main", 1.8, manner="blind"), events=[TimedEvent(1.0, vehicle="red", do="reverse")], until_s=2.0
    )
    assert speeds(truths)[-1, 0] == 0.0


def test_a_switch_moves_in_its_own_time():
    truths = run(events=[TimedEvent(0.1, switch="S1", set="diverging")], until_s=0.5, step_s=0.05)
    told = [(event.time_ns, event.detail) for event in happened(truths, EventKind.SWITCH)]
    assert told == [(100_000_000, "moving"), (350_000_000, "diverging")]
    states = {truth.time_ns: truth.switches["S1"] for truth in truths}
    assert states[50_000_000] is SwitchState.STRAIGHT
    assert states[100_000_000] is states[300_000_000] is SwitchState.MOVING
    assert states[350_000_000] is SwitchState.DIVERGING


def test_a_switch_waits_until_the_vehicle_on_it_has_left():
    truths = run(
        vehicle(offset_m=1.9, speed_mps=0.2, operates_switches=False),
        events=[TimedEvent(0.5, switch="S1", set="diverging")],  # the vehicle is on the toe from 0.2 s to 0.8 s
        until_s=1.5,
    )
    moving, arrived = happened(truths, EventKind.SWITCH)
    assert 0.8 <= seconds(moving) <= 0.8 + 2 * STEP_S
    assert abs(seconds(arrived) - seconds(moving) - 0.25) < 1e-9
    assert truths[-1].places[0].section == "main"


def test_a_vehicle_asks_for_its_route_15_cm_before_the_points():
    truths = run(vehicle(offset_m=1.5, speed_mps=0.4, route={"S1": "diverging"}), until_s=2.5)
    asked, _ = happened(truths, EventKind.SWITCH)
    assert 0 <= seconds(asked) - (0.5 - 0.06 - 0.15) / 0.4 <= STEP_S + 1e-9
    assert truths[-1].places[0].section == "side"


def test_a_vehicle_from_a_branch_asks_for_that_branch():
    truths = run(vehicle("side", 0.6, "backward"), until_s=2.5)
    assert truths[-1].places[0].section == "stem"
    assert truths[-1].switches["S1"] is SwitchState.DIVERGING


@pytest.mark.parametrize("keys", [{"link": "dead"}, {"link_failure": 1.0}, {"operates_switches": False}])
def test_without_its_link_a_blind_vehicle_derails_on_a_switch_that_lies_against_it(keys):
    truths = run(vehicle("side", 0.6, "backward", manner="blind", **keys), until_s=2.5)
    (event,) = happened(truths, EventKind.DERAIL)
    assert abs(seconds(event) - (0.6 - 0.06) / 0.4) < 1e-8


def test_the_seed_decides_which_requests_are_lost_and_nothing_else():
    red = vehicle("side", 0.6, "backward", manner="blind", link_failure=0.5)
    ends = {}
    for seed in range(12):
        (*_, last) = RailMotion(FORK, MotionSpec((red,)), seed).run([0, 2_500_000_000])
        ends.setdefault(last.switches["S1"], set()).add(last.positions_m.tobytes())
    assert {state: len(places) for state, places in ends.items()} == {
        SwitchState.STRAIGHT: 1,
        SwitchState.DIVERGING: 1,
    }


def test_an_empty_plant_has_a_truth_without_rows():
    (truth,) = RailMotion(FORK, MotionSpec(()), 1).run([0])
    assert truth.positions_m.shape == (0, 3)
    assert truth.switches == {"S1": SwitchState.STRAIGHT}


def slowly_to_and_fro(outlook):
    return 0.2 if outlook.time_s < 0.5 else -0.2


def test_a_behaviour_named_by_path_drives_the_vehicle():
    truths = run(vehicle(behaviour="test_motion:slowly_to_and_fro"), until_s=2.5)
    assert abs(truths[20].velocities_mps[0, 0] - 0.2) < 1e-9
    assert abs(truths[-1].velocities_mps[0, 0] + 0.2) < 1e-9


@pytest.mark.parametrize(
    ("vehicles", "keys", "words"),
    [
        ([vehicle("nowhere")], {}, ["section", "'nowhere'", "stem, main, side"]),
        ([vehicle(offset_m=2.5)], {}, ["2.5 m", "'stem'", "2.000 m long"]),
        ([vehicle(offset_m=0.03)], {}, ["vehicle red", "0.060 m of free track", "buffer"]),
        ([vehicle("side", 0.03)], {}, ["vehicle red", "S1", "switch against"]),
        ([vehicle(heading="north")], {}, ["runs across north", "forward, backward"]),
        ([vehicle(), vehicle(offset_m=1.1, colour="blue")], {}, ["blue and red", "touch at the start"]),
        ([vehicle(route={"S9": "straight"})], {}, ["switch", "'S9'", "S1"]),
        ([vehicle()], {"switches": {"S9": "straight"}}, ["switch", "'S9'", "S1"]),
        ([vehicle()], {"events": [TimedEvent(1.0, switch="S9", set="straight")]}, ["'S9'"]),
        ([vehicle()], {"events": [TimedEvent(1.0, vehicle="blue", do="stop")]}, ["'blue'", "red"]),
        ([vehicle(behaviour="no.such:thing")], {}, ["behaviour", "no.such:thing"]),
        ([vehicle(behaviour="math:pi")], {}, ["math:pi", "not a function"]),
    ],
)
def test_what_the_plant_cannot_serve_is_refused_by_name(vehicles, keys, words):
    with pytest.raises(InputError) as refusal:
        run(*vehicles, until_s=0.1, **keys)
    for word in words:
        assert word in str(refusal.value)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: vehicle(speed_mps=float("nan")), ["speed_mps"]),
        (lambda: vehicle(wheelbase_m=0.0), ["wheelbase_m", "positive"]),
        (lambda: vehicle(wheelbase_m=0.2), ["wheelbase_m", "0.12"]),
        (lambda: vehicle(braking_mps2=-1.0), ["braking_mps2"]),
        (lambda: vehicle(size_m=(0.12, 0.06, float("inf"))), ["size_m[2]"]),
        (lambda: vehicle(link_failure=1.5), ["link_failure", "[0, 1]"]),
        (lambda: TimedEvent(-1.0, switch="S1", set="straight"), ["at_s = -1.0"]),
        (lambda: TimedEvent(1.0, switch="S1"), ["switch and set"]),
        (lambda: TimedEvent(1.0, vehicle="red", switch="S1"), ["vehicle and do"]),
        (lambda: TimedEvent(1.0, vehicle="red", speed_mps=float("inf")), ["speed_mps"]),
        (lambda: MotionSpec((vehicle(), vehicle(offset_m=1.5))), ["2 vehicles", "id red"]),
        (lambda: MotionSpec((), switch_travel_s=-0.1), ["switch_travel_s"]),
    ],
)
def test_impossible_specifications_are_refused(make, words):
    with pytest.raises(InputError) as refusal:
        make()
    for word in words:
        assert word in str(refusal.value)


def test_times_must_rise():
    motion = RailMotion(FORK, MotionSpec(()), 1)
    for wrong in ([0, 0], [5, 4], [-1]):
        with pytest.raises(InputError, match="must rise"):
            list(motion.run(wrong))
