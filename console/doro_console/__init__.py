"""The command ``doro``: starts, plays, says, shows. It may use every service's core."""
