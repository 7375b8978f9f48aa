"""Write the Python code of the pages as files for type checkers: pages.py FOLDER.

One file a page, each line at the number that it has there, so that what a checker says of
`docs/parts.md.py:120` is line 120 of docs/parts.md. Blocks that show what happens to wrong input
end in an error on purpose and are left out: a text block that names the error follows them.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OWN = ("own-element.md",)  # adds a file to jousto itself, which is not there
BLOCK = re.compile(r"^```python\n(.*?)^```$(\s*^```text\n\w*Error: )?", re.M | re.S)


def code(text: str) -> str:
    """Return the code of a page, all else as empty lines."""
    lines = [""] * text.count("\n")
    for match in BLOCK.finditer(text):
        if match[2]:
            continue
        first = text.count("\n", 0, match.start(1))
        block = match[1].splitlines()
        lines[first : first + len(block)] = block
    return "\n".join([*lines, ""])


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        if path.name in OWN:
            continue
        target = folder / f"{path.relative_to(ROOT)}.py"
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(code(path.read_text(encoding="utf-8")), encoding="utf-8")
