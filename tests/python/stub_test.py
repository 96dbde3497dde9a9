"""The stubs name what there is, and every public name has a docstring."""
import ast
import os
import unittest

import hapton


def names_in(stub):
    with open(os.path.join(os.path.dirname(hapton.__file__), stub)) as file:
        tree = ast.parse(file.read())
    names = {}
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            names[node.name] = {part.name for part in node.body if isinstance(part, ast.FunctionDef)}
        elif isinstance(node, ast.FunctionDef):
            names[node.name] = set()
    return names


def public(thing):
    return {name for name in dir(thing) if not name.startswith("_")}


class StubTest(unittest.TestCase):
    def test_names_what_the_module_has(self):
        stub = names_in("__init__.pyi")
        self.assertEqual(set(stub) | {"fields"}, set(hapton.__all__))
        self.assertEqual(set(names_in("fields.pyi")), public(hapton.fields))

    def test_names_what_the_classes_have(self):
        for name, methods in names_in("__init__.pyi").items():
            if isinstance(getattr(hapton, name), type):
                self.assertEqual({m for m in methods if not m.startswith("_")}, public(getattr(hapton, name)), name)

    def test_everything_has_a_docstring(self):
        for name in hapton.__all__:
            self.assertTrue(getattr(hapton, name).__doc__, name)
        for name in public(hapton.fields):
            self.assertTrue(getattr(hapton.fields, name).__doc__, name)

    def test_the_package_is_typed(self):
        self.assertTrue(os.path.exists(os.path.join(os.path.dirname(hapton.__file__), "py.typed")))


if __name__ == "__main__":
    unittest.main()
