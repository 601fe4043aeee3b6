"""What people read of a run: a summary in the terminal and one self-contained HTML page."""
