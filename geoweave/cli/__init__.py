"""The ``geoweave`` command: each module parses, calls and prints."""
