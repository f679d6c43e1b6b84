"""The scope's loops and files: attach to a run, keep the selected values, save, reopen, export, draw."""
