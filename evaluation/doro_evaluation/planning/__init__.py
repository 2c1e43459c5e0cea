"""How many views the next-view planner needs, beside other orders."""
