"""Methods that know no sensor: minimization, suprema, routes, arrays."""
