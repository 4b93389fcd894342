"""makes scans."""
