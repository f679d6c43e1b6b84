"""The scope: channels out of the cycle's own records, trigger with pre-trigger."""
