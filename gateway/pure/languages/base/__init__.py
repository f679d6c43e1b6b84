"""What the languages of all old controls share: positions, faults, requests, processes, scheduler, debugging, trace."""
