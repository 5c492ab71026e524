"""Place bodies, fit them to surfaces and measures, and describe populations."""
