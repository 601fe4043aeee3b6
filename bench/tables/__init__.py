"""The papers' tables and figures, remade on frames whose truth is known; each figure beside the paper's.

One file makes one table: a pure function from what was watched to a ``Part``. ``films`` films each sequence once and
keeps it in memory, so that all detectors and trackers see the same frames.
"""
