"""Pixels, ground and map: camera model, calibration, location with covariance, fusion."""
