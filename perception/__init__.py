"""Frames in, tracks out. Sees pixels only."""
