"""Seating: people into seats and at wheels, where view and pedals are had."""
