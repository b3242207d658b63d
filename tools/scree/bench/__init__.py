"""What scree costs (`tools/bench`)."""
