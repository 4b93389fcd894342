"""Arrays in, arrays out: the kernels and the mathematics that more than one stage needs."""
