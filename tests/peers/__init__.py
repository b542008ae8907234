"""Tests against real programs; run with ``pytest -m peer`` after tests/peers/install.sh."""
