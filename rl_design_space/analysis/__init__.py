"""Analysis: functions from recorded results to frames and estimates, without input, output or learning."""
