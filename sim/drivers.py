"""How a vehicle chooses its speed: a function from what it sees to what it wants."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from math import copysign, inf, sqrt

from contracts import InputError
from sim.motion_spec import Manner, VehicleSpec

STANDOFF_M = 0.03  # air that an attentive vehicle keeps to whatever it stops for
COMFORT = 0.8  # share of the brakes that it plans with, so that the rest can make good for a step's delay


@dataclass(frozen=True)
class Outlook:
    """What a driver knows at one moment; speeds along the vehicle, positive the way it faces.

    commanded_mps: what the scenario last told it. speed_mps: its own speed.
    gap_m: track between its leading end and what it cannot pass; infinite where nothing is in sight.
    obstacle_mps: how fast that goes away, negative if it comes nearer.
    """

    time_s: float
    vehicle: VehicleSpec
    commanded_mps: float
    speed_mps: float
    gap_m: float = inf
    obstacle_mps: float = 0.0


Driver = Callable[[Outlook], float]  # the speed wanted, positive the way the vehicle faces; limits are kept for it


def blind(outlook: Outlook) -> float:
    """The commanded speed, come what may."""
    return outlook.commanded_mps


def attentive(outlook: Outlook) -> float:
    """The commanded speed, but never more than allows a stop behind the obstacle, should that brake too.

    Source: Gipps 1981, A behavioural car-following model, eq. 10, without reaction time.
    """
    braking = COMFORT * outlook.vehicle.braking_mps2
    obstacle_stops_m = copysign(outlook.obstacle_mps**2 / (2.0 * outlook.vehicle.braking_mps2), outlook.obstacle_mps)
    room_m = max(0.0, outlook.gap_m - STANDOFF_M + obstacle_stops_m)
    return copysign(min(abs(outlook.commanded_mps), sqrt(2.0 * braking * room_m)), outlook.commanded_mps)


def driver_of(vehicle: VehicleSpec) -> Driver:
    """The driver that ``behaviour`` names, or else that of its manner; InputError if there is no such function."""
    if vehicle.behaviour is None:
        return {Manner.ATTENTIVE: attentive, Manner.BLIND: blind}[vehicle.manner]
    return imported(vehicle.behaviour, f"vehicle {vehicle.id}: behaviour")


def imported(path: str, what: str) -> Driver:
    """The function at ``"package.module:function"``."""
    module_name, _, name = path.partition(":")
    try:
        function = getattr(import_module(module_name), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(f'{what} = "{path}" is no "package.module:function" that can be imported: {error}') from error
    if not callable(function):
        raise InputError(f'{what} = "{path}" is not a function')
    driver: Driver = function
    return driver
