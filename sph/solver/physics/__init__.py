"""Terms of physics, one a file: kernels, constitutive laws, their coupling, and the forces between particles."""
