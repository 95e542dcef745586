"""The use cases of design: a program for a problem, a given one evaluated, and all that can be asked beside."""
