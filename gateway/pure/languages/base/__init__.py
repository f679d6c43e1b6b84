"""What the languages of all old controllers share: positions, faults, requests, processes, scheduler, debugging, trace."""
