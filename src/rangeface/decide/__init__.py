"""scores and Assessment → Decision."""
