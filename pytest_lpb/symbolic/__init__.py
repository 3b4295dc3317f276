"""What planners composed in CasADi share: functions through buffers, compiled functions, expressions."""
