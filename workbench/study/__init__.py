"""Studies: one module a question; run(study) composes the solvers into a Result."""
