"""The model railway as geometry and graph. No pixels, no motion."""
