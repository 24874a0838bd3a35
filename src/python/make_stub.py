"""make_stub.py PACKAGE TEMPLATE: writes PACKAGE/__init__.pyi, with the scene's keywords."""

import importlib.util
import pathlib
import sys

TYPES = {"text": "Path", "flag": "bool", "int": "int", "size": "Union[int, str]",
         "float": "Union[float, str]", "pixels": "Union[str, Sequence[int]]", "choice": "str",
         "opacity": "Union[str, Sequence[Sequence[float]]]", "plane": "Numbers",
         "numbers": "Numbers", "grey": "Union[float, Numbers]",
         "lights": "Union[Numbers, Sequence[Numbers]]", "texts": "Union[Path, Sequence[Path]]"}


def main(package, template):
    path, = pathlib.Path(package).glob("_core*.so")
    spec = importlib.util.spec_from_file_location("_core", path)
    core = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(core)
    rows = [f"    {row['name'].replace('-', '_')}: Optional[{TYPES[row['kind']]}]"
            for row in core.parameters()]
    text = pathlib.Path(template).read_text(encoding="utf-8").replace("@SCENE@", "\n".join(rows))
    (pathlib.Path(package) / "__init__.pyi").write_text(text, encoding="utf-8")


main(*sys.argv[1:])
