"""What flows through the house: parameters, stimulus, information, units."""
