"""tools/study: one scene with many numbers."""
