"""The sealed proof of the discovery engine: causes are drawn, hidden, simulated in time, and looked for."""
