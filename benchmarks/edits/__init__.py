"""Edits of the program, and libraries installed beside it: which stages are stale then, and which should be.

``python -m benchmarks.edits [--edits 200]`` prints Markdown. A copy of the program is edited at random places, one at a
time: a number or an operator in a module of which some stage ran a function; prose; a number or an operator in a module
that no stage ran. What should be stale comes from a trace of what each stage of a small study ran, in a process of its
own, its child processes too. A hit is a stage that is stale by an edit. It is wanted if the stage ran the module: a
function of it, or nothing but the module itself when it was imported, which makes its constants (imported only). All
others are needless. Missed is a stage that should be stale and is not.
"""
