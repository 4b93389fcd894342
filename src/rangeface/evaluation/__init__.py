"""error rates, intervals, protocols, reports."""
