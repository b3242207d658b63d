"""One page of a run that needs nothing else (`tools/report`)."""
