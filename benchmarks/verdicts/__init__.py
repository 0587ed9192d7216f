"""Families of runs with known answers: does `converge` say "converged" only where its error bar holds the truth?"""
