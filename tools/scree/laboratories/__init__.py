"""Tests of specimens of bonded grains (`tools/test_rock`), and grains as block files (`tools/grains`)."""
