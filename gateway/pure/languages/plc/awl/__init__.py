"""Statement lists of STEP 5 and STEP 7 become programs of the integrated PLC."""
