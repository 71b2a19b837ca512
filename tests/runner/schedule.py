"""Says which step of a run may begin, and how long the whole run will still take."""


def failed_needs(step, passed, ended):
    """Names of the steps that this one needs and that did not pass."""
    return [name for name in step.needs if name in ended and name not in passed]


def may_begin(step, running, ended):
    """Returns whether a step may begin beside the steps that run, where those with these names have ended."""
    return all(name in ended for name in step.needs) and all(
        other.name in step.beside or step.name in other.beside for other in running)


def time_left(running, waiting, ended, expected):
    """Seconds until all have ended. `running` are pairs of a step and its seconds left, `waiting` steps, none of which
    overtakes another. `ended` are names, and `expected(step)` is the seconds of one that waits."""
    running, waiting, ended = list(running), list(waiting), set(ended)
    total = 0.0
    while running or waiting:
        while waiting and may_begin(waiting[0], [step for step, _ in running], ended):
            step = waiting.pop(0)
            running.append((step, expected(step)))
        if not running:  # A step that waits for one that is not in the run would wait for ever.
            break
        passes = min(left for _, left in running)
        total += passes
        ended |= {step.name for step, left in running if left <= passes}
        running = [(step, left - passes) for step, left in running if left > passes]
    return total
