"""Figures. Off by default; run with ``pytest -m bench -s``."""
