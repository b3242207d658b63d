"""Falls of many single rocks on a slope (`tools/rockfall`)."""
