"""The detectors that paper R compares its own with: colour range, colour component ratio, mixture of Gaussians.

Each says of every pixel of the whole frame whether it has a vehicle's colour; what follows is the same for all of them
and for histogram back-projection. Nothing here is meant to serve a run but as the thing to be better than.
"""
