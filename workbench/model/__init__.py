"""The nouns: frozen arrays with their invariants, and the vocabulary."""
