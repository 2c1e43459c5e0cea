"""Questionnaires about queries, and what came of them."""
