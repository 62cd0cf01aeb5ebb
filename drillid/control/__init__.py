"""Speed control of the top drive: stability margins, tuning, stick-slip, a virtual sensor at the bit."""
