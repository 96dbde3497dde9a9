"""Runs the code cells of a notebook, without Jupyter: python3 -m hapton.run_notebook tutorial.ipynb"""
import json
import os
import sys


def run_notebook(path):
    """Executes the code cells from top to bottom, in the notebook's folder. Returns the variables that they define, by name. An error message
    contains the number of its cell. Lines that begin with % or ! are commands of Jupyter and are left out."""
    with open(path) as file:
        notebook = json.load(file)
    names = {"__name__": "__main__"}
    before = os.getcwd()
    os.chdir(os.path.dirname(os.path.abspath(path)))
    try:
        for number, cell in enumerate(notebook["cells"], 1):
            if cell["cell_type"] != "code":
                continue
            lines = "".join(cell["source"]).split("\n")
            text = "\n".join("" if line.startswith(("%", "!")) else line for line in lines)
            try:
                exec(compile(text, f"cell {number}", "exec"), names)
            except Exception as problem:
                raise RuntimeError(f"{path}: cell {number}: {type(problem).__name__}: {problem}") from problem
    finally:
        os.chdir(before)
    return names


def main(arguments):
    if len(arguments) != 1 or arguments[0] in ("-h", "--help"):
        print(__doc__)
        return 0 if arguments and arguments[0] in ("-h", "--help") else 2
    try:
        run_notebook(arguments[0])
    except (OSError, ValueError, KeyError, RuntimeError) as problem:
        print(f"run_notebook: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
