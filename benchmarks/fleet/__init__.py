"""What a fleet costs and survives: planning, overhead, speed-up, nights and faults."""
