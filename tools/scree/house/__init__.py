"""What the house asks of its Fortran: rooms in one direction, procedures that fit on a page, one layout (tools/check)."""
