"""What the owners' commands do: calibrate a real camera and place its pixels. No simulation is loaded."""
