"""What is asked for with a program: orientation, order of visit, smallest number of positions, figures of merit."""
