"""The scope's loops and files: attach to a run, keep what was asked for, save, reopen, export, draw."""
