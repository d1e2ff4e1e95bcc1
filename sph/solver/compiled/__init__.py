"""How the solver is compiled and where compiled code is kept; the threads that share a large scene."""
