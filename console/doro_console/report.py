"""How a query is told to a person at a terminal."""

from __future__ import annotations

from doro_schemas.messages import Clause, InstructionGraph, Query, Target


def describe_graph(parsed: InstructionGraph) -> str:
    """Return what nlu understood, in one line."""
    if parsed.graph is None:
        return f"not understood: {parsed.reason}"
    graph = parsed.graph
    words = [graph.name]
    words += [f"{kind}: {value}" for kind, value in graph.attributes.items()]
    words += [
        f"{'with: ' if relation.inverse else ''}{relation.type}: "
        + " ".join([*relation.target.attributes.values(), relation.target.name])
        for relation in graph.relations
    ]
    return ", ".join(words)


def describe_query(query: Query) -> list[str]:
    """Return a query as lines: the words first, then state, and the evidence of each clause."""
    lines = [f'robot:  "{query.text}"']
    lines.append(
        f"why:    {query.state} ({query.reason}): {len(query.matches)} of"
        f" {len(query.instances)} found match"
    )
    for number, clause in enumerate(query.clauses, 1):
        lines += [f"  {number}. {clause.text}", *_evidence(clause)]
    return lines


def describe_target(target: Target) -> str:
    """Return where the robot may go, in one line."""
    position = ", ".join(f"{value:.2f}" for value in target.position_m)
    return f"target: {target.instance_id} at {position} m"


def _evidence(clause: Clause) -> list[str]:
    lines = [f"     {', '.join(clause.instance_ids)} on {len(clause.cells)} cells"]
    for view in clause.evidence[:3]:
        xmin, ymin, xmax, ymax = view.box_px
        lines.append(
            f"     seen in frame {view.frame} of {view.camera},"
            f" box {xmin:.0f},{ymin:.0f}-{xmax:.0f},{ymax:.0f}: {view.caption}"
        )
    return lines
