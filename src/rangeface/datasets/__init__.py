"""A user's folder → list of Scan, with the database's published protocols."""

from rangeface.datasets.folder import folder
from rangeface.datasets.rap3df import rap3df

__all__ = ["folder", "rap3df"]
