"""Strain: scores of postures, lifting, static loads and strength."""
