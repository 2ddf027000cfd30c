"""``python -m stickslip`` is the program."""

from ._program import replace_this_process

if __name__ == "__main__":
    replace_this_process()
