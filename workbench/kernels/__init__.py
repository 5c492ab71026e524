"""The compiled code: scalar inline functions, and one batch loop for each query. Nothing else knows
the compiler."""
