"""What is done with a rig and in a session, as functions: the command line and a notebook call the same ones.

They take settings and callbacks, return frozen results, raise the errors of the project, and print nothing.
"""
