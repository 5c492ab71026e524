"""The live bench: a study in the browser, answered while it is changed."""
