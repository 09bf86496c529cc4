"""Speed, memory and growth, measured in one run and stated as ratios."""
