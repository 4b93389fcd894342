"""a user's folder → list of Scan, with the database's published protocols."""
